"""Commands of ``cb``: built-in ones, and those of packages in the group ``cbdsl.commands``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from cbdsl.types.registry import PluginError, Registry

if TYPE_CHECKING:
    import typer

Command: TypeAlias = "Callable[..., Any] | typer.Typer"
"""Function that Typer turns into a command, or an app with commands of its own."""

_BUILT_IN = (
    "validate", "list", "run", "explain", "show", "new", "schema", "replay", "learn",
    "explore", "report", "calibrate", "lsp", "fmt", "export", "warm", "drive",
)  # fmt: skip

#: Modules of commands that are not named like their command.
_MODULES = {"show": "show.show"}

#: Packages of this project that add commands.
_PACKAGES = {"reproduce": "cbdsl-reproduction"}


def missing_package(name: str) -> str | None:
    """Return the package that adds a command, if the command is not installed."""
    return _PACKAGES.get(name) if name not in COMMANDS else None


def add_command(app: typer.Typer, name: str, command: Command) -> None:
    """Add a command to an app."""
    import typer

    if isinstance(command, typer.Typer):
        app.add_typer(command, name=name)
    else:
        app.command(name)(command)


def _validate(name: str, entry: object) -> Command:
    if name in _BUILT_IN:
        return entry  # type: ignore[return-value]  # held by tests of each command
    import typer

    if not callable(entry):
        raise PluginError(f"is a {type(entry).__name__}, neither a function nor a typer.Typer")
    # Typer reads the signature of a function when it builds a group. A faulty plug-in fails here,
    # by itself, and does not break the list of all commands.
    app = typer.Typer()
    add_command(app, name, entry)
    try:
        described = typer.main.get_group(app).commands[name].help
    except Exception as error:
        raise PluginError(f"is no command: {error}") from error
    if not described:
        raise PluginError("has no help: give it a docstring")
    return entry


#: Commands by name.
COMMANDS: Registry[Command] = Registry(
    "command",
    "cbdsl.commands",
    {name: f"cbdsl.cli.{_MODULES.get(name, name)}:{name}" for name in _BUILT_IN},
    _validate,
)

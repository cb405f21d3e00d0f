"""Commands of ``cb``: built-in ones, and those of packages in the group ``cbdsl.commands``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from cbdsl.types.registry import PluginError, Registry

if TYPE_CHECKING:
    import typer

Command: TypeAlias = "Callable[..., Any] | typer.Typer"
"""Function that Typer turns into a command, or an app with commands of its own."""

#: First paragraph of the help of each built-in command, which lists it without its import.
SUMMARIES = {
    "validate": "Check documents without running them.",
    "list": "List the documents that commands find by name from this folder, with their paths.",
    "run": "Run a program on a robot and print each change of its state.",
    "explain": "Print the meaning of a diagnostic, its reason, and a wrong and a correct example.",
    "show": "Show types, potentials, resources, plug-ins, programs, meshes, and learned knowledge.",
    "new": "Write a robot, program or stage to start from.",
    "schema": "Print the JSON Schema of a kind of document, or write it for editors and CI.",
    "replay": "Write a self-contained page of a recorded episode.",
    "learn": "Learn the values of a program's actions from scratch, by discovering affordances.",
    "explore": "Explore the affordances of an object until its models have habituated (Chapter 6).",
    "lsp": "Serve an editor over the standard streams: diagnostics while typing, completion, "
    "hover.",
    "fmt": "Format documents: uniform indentation and spacing, without superfluous empty lines.",
    "export": "Write programs and recordings in formats of other tools.",
    "warm": "Compile in advance for all installed engines, so that first runs start immediately.",
}
#: Built-in commands that have commands of their own.
GROUPS = ("show", "new", "export")

#: Modules of commands that are not named like their command.
_MODULES = {"show": "show.show"}

#: Requirements of this project that add commands.
_PROVIDERS = {
    "reproduce": "cbdsl-reproduction",
    "judge": "cbdsl-reproduction",
    "calibrate": "cbdsl[calibration]",
    "compare": "cbdsl[compare]",
    "drive": "cbdsl[ros2]",
    "playground": "cbdsl[report]",
    "report": "cbdsl[report]",
    "drive.serve": "cbdsl[ros2]",
    "drive.watchdog": "cbdsl[ros2]",
    "export.tree": "cbdsl[trees]",
    "why": "cbdsl[why]",
}


def add_command(app: typer.Typer, name: str, command: Command) -> None:
    """Add a command to an app, and to a group of commands those of packages."""
    import typer

    from cbdsl.cli.arguments.option_groups import GroupedCommand
    from cbdsl.cli.command_group import CommandGroup

    if isinstance(command, typer.Typer):
        app.add_typer(
            command.complete() if isinstance(command, CommandGroup) else command, name=name
        )
    else:
        app.command(name, cls=GroupedCommand)(command)


def main_names() -> tuple[str, ...]:
    """Return the names of all usable commands without those of groups, such as `drive.serve`."""
    return tuple(name for name in COMMANDS.usable_names() if "." not in name)


def commands_of(group: str) -> Iterator[tuple[str, Callable[[], Command]]]:
    """Yield the names of a group's commands from packages, and functions that return them."""
    for name in (*COMMANDS.names(), *COMMANDS.missing()):
        before, _, part = name.partition(".")
        if before == group and part:
            yield part, partial(COMMANDS.get, name)


def add_summary(app: typer.Typer, name: str) -> None:
    """Add a command to an app that only lists its commands; built-in ones are not imported."""
    import typer

    if name in GROUPS:
        app.add_typer(typer.Typer(), name=name, help=SUMMARIES[name])
    elif name in SUMMARIES:
        app.command(name, help=SUMMARIES[name])(_listed)
    else:
        add_command(app, name, COMMANDS.get(name))


def _listed() -> None:
    """Stand for a command in a list."""


def _validate(name: str, entry: object) -> Command:
    if name in SUMMARIES:
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
    {name: f"cbdsl.cli.{_MODULES.get(name, name)}:{name}" for name in SUMMARIES},
    _validate,
    providers=_PROVIDERS,
)

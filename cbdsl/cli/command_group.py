"""Groups of commands to which other packages add commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import typer

from cbdsl.diagnostics.errors import UsageError
from cbdsl.types.registry import PluginError

Parts = Iterable[tuple[str, Callable[[], Any]]]


class CommandGroup(typer.Typer):
    """Commands of one group, built-in ones and those of packages.

    Args:
        parts: Function that yields the name of each command of a package, and a function that
            returns the command; it raises UsageError if the package is missing or faulty.
        help: First line of the help.
    """

    def __init__(self, parts: Callable[[], Parts], help: str) -> None:
        super().__init__(
            help=help, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
        )
        self._parts = parts

    def complete(self) -> typer.Typer:
        """Return an app with the commands of the packages that are installed now."""
        app = CommandGroup(self._parts, str(self.info.help))
        app.registered_commands = list(self.registered_commands)
        for name, read in self._parts():
            try:
                app.command(name)(read())
            except UsageError as error:
                _add_unusable(app, name, error)
        return app


def _add_unusable(app: typer.Typer, name: str, error: UsageError) -> None:
    """Add a command that raises an error, and says why in its help."""

    def refuse() -> None:
        raise error

    settings = {"ignore_unknown_options": True, "allow_extra_args": True}
    state = "Unusable" if isinstance(error, PluginError) else "Not installed"
    app.command(name, help=f"{state}: {error}.", context_settings=settings)(refuse)

"""Contract of commands: help for each command, argument and option."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import typer

from cbdsl.cli.commands import COMMANDS, add_command


def _leaves(command: Any) -> Iterator[Any]:
    """Yield a command, or the commands of a group."""
    for part in getattr(command, "commands", {}).values():
        yield from _leaves(part)
    if not hasattr(command, "commands"):
        yield command


@pytest.mark.parametrize(
    "name", [name for name in COMMANDS.usable_names() if not COMMANDS.is_builtin(name)]
)
def test_command_and_its_options_have_help(name: str) -> None:
    app = typer.Typer()
    app.callback()(lambda: None)
    add_command(app, name, COMMANDS.get(name))
    for leaf in _leaves(typer.main.get_command(app)):
        assert leaf.help, leaf.name
        bare = [parameter.name for parameter in leaf.params if not getattr(parameter, "help", "")]
        assert bare == [], f"{name} {leaf.name}: no help"

"""Groups of options: one parameter of a command, several options of the command line."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import typer
from typer.testing import CliRunner

from cbdsl.cli.arguments.option_groups import grouped

Size = Annotated[int, typer.Option("--size", min=1, help="Size of the box.")]
Names = Annotated[list[str], typer.Option("--name", help="Name of a box.")]


@dataclass(frozen=True, kw_only=True)
class BoxOptions:
    """Options of a box."""

    size: Size
    name: Names = field(default_factory=list)


def _invoke(*words: str) -> tuple[int, str]:
    received: list[object] = []

    @grouped
    def pack(
        context: typer.Context,
        word: str,
        *,
        box: BoxOptions,
        fast: Annotated[bool, typer.Option("--fast")] = False,
    ) -> None:
        """Pack a box."""
        received.extend([word, box, fast, [each.name for each in context.command.params]])

    app = typer.Typer(add_completion=False)
    app.command()(pack)
    result = CliRunner().invoke(app, list(words))
    return result.exit_code, str(received) if received else result.output


def test_grouped_command_receives_its_group_and_its_other_parameters() -> None:
    code, received = _invoke("w", "--size", "2", "--name", "a", "--name", "b", "--fast")
    names = ["word", "size", "name", "fast"]
    assert (code, received) == (0, str(["w", BoxOptions(size=2, name=["a", "b"]), True, names]))


def test_grouped_command_keeps_defaults_bounds_and_required_options() -> None:
    assert "BoxOptions(size=3, name=[])" in _invoke("w", "--size", "3")[1]
    assert _invoke("w", "--size", "0")[0] == 2
    assert _invoke("w")[0] == 2
    assert "Size of the box." in _invoke("--help")[1]

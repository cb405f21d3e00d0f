"""Formats of ``cb show``."""

from __future__ import annotations

from collections.abc import Collection
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.diagnostics.errors import UsageError
from cbdsl.reporting.drawing.dot import dot
from cbdsl.reporting.drawing.mermaid import mermaid
from cbdsl.reporting.drawing.svg import svg

if TYPE_CHECKING:
    from cbdsl.reporting.drawing.graph import Graph


class Format(StrEnum):
    """Output format."""

    TEXT = "text"
    JSON = "json"
    DOT = "dot"
    MERMAID = "mermaid"
    SVG = "svg"


#: Formats of data without a graph.
PLAIN = (Format.TEXT, Format.JSON)
#: Formats of data with a single picture.
PICTURED = (*PLAIN, Format.SVG)

PlainFormat = Annotated[str, typer.Option("--format", help="Output format: text or json.")]
Json = Annotated[bool, typer.Option("--json", help="Short for --format json.")]


def read_format(word: str, as_json: bool, offered: Collection[Format] = tuple(Format)) -> Format:
    """Return the format of a name.

    Args:
        word: Name of a format.
        as_json: True for JSON, regardless of the name.
        offered: Formats of the command.

    Raises:
        UsageError: The command has no format of this name.
    """
    # A wrong name is an error beside `as_json` as well.
    known = {form.value: form for form in offered}
    if word not in known:
        raise UsageError.unknown("format", word, known)
    return Format.JSON if as_json else known[word]


def drawing(graph: Graph, form: Format) -> str:
    """Return a graph in one of the formats for graphs."""
    draw = {Format.DOT: dot, Format.MERMAID: mermaid, Format.SVG: svg}[form]
    return draw(graph)

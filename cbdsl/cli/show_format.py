"""How ``cb show`` shows a program or a policy."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

from cbdsl.errors.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.reporting.drawing.graph import Graph


class Format(StrEnum):
    """How a program or a policy is shown."""

    TEXT = "text"
    JSON = "json"
    DOT = "dot"
    MERMAID = "mermaid"
    SVG = "svg"


def read_format(word: str, as_json: bool) -> Format:
    """The format of a name.

    Args:
        word: its name.
        as_json: whether it is JSON, whatever the word.

    Raises:
        UsageError: there is none of this name.
    """
    known = {form.value: form for form in Format}
    if word not in known:
        raise UsageError.unknown("format", word, known)
    return Format.JSON if as_json else known[word]


def drawing(graph: Graph, form: Format) -> str:
    """A graph in one of the formats for graphs."""
    from cbdsl.reporting.drawing.dot import dot
    from cbdsl.reporting.drawing.mermaid import mermaid
    from cbdsl.reporting.drawing.svg import svg

    draw = {Format.DOT: dot, Format.MERMAID: mermaid, Format.SVG: svg}[form]
    return draw(graph)

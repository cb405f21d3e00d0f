"""Commas that split a value: decimal commas, and lists without brackets."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.yaml_text.node import Node


# A comma ends a value within braces and brackets. From {gain: 1,5} YAML reads the value 1 and a
# second key "5" without a value; from [1,5] it reads two items. A quantity in the place of a key,
# followed by a comma or the closing brace, is thus a part of the value before it. Without a space
# after the comma, two halves of digits are certainly a decimal comma. With a space, a list may be
# intended as well, so that the value is ambiguous and is not repaired.
class Stray(NamedTuple):
    """Quantity in the place of a key, because a comma ended the preceding value."""

    text: str
    place: Place


class Cut(NamedTuple):
    """Explanation of a value that a comma split.

    Attributes:
        problem: Diagnostic message, as a clause.
        whole: Text of the whole value, if it is unambiguous.
    """

    problem: str
    whole: str | None = None


def is_stray(text: str, rest: str) -> bool:
    """Return whether a quantity without a colon stands in the place of a key.

    Args:
        text: Text in the place of the key.
        rest: Remainder of the line after the text.
    """
    begins = text.lstrip("+-.")[:1]
    return begins.isdigit() and rest.lstrip()[:1] in (",", "}")


def explain(key: str, value: Node, strays: Sequence[Stray]) -> Cut:
    """Explain which value a key's value and the stray quantities after it form."""
    parts = [_shown(value), *(stray.text for stray in strays)]
    row = f"[{', '.join(parts)}]"
    if len(parts) != 2 or not _are_halves(value, parts[1]):
        return Cut(f"a list is written in brackets; write '{key}: {row}'")
    whole = ".".join(parts)
    if _is_tight(value.place, strays[0].place):
        return Cut(_decimal(*parts), whole)
    return Cut(f"a ',' ends the value; write '{key}: {whole}', or '{key}: {row}' for a list")


def decimal_comma(node: Node) -> str | None:
    """Return the message about a decimal comma in a list, or ``None``."""
    items = node.value if isinstance(node.value, list) else []
    for one, other in pairwise(items):
        if _is_tight(one.place, other.place) and _are_halves(one, other.written):
            return _decimal(one.written, other.written)
    return None


def _shown(value: Node) -> str:
    """Return the text of a value, with the contents of collections abbreviated."""
    if isinstance(value.value, list):
        return "[...]"
    return "{...}" if isinstance(value.value, dict) else value.written or str(value.value)


def _are_halves(whole: Node, rest: str) -> bool:
    """Return whether two values may be the integer and fractional parts of one number."""
    # In Python, a boolean is an integer, too.
    return type(whole.value) is int and whole.written != "" and rest[:1].isdigit()


def _is_tight(one: Place, other: Place) -> bool:
    """Return whether only a comma separates two values, without a space."""
    return (one.line, one.end_column + 1) == (other.line, other.column)


def _decimal(whole: str, rest: str) -> str:
    return f"'{whole},{rest}' has a decimal comma; write '{whole}.{rest}'"

"""Commas that cut a value in two: decimal commas, and lists without their brackets."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from cbdsl.errors.diagnostic import Place
from cbdsl.yaml_text.node import Node


class Stray(NamedTuple):
    """A quantity where a key should be, because a comma ended the value before it."""

    text: str
    place: Place


class Cut(NamedTuple):
    """A value that a comma ended.

    Attributes:
        problem: what is to be said of it, as a clause.
        whole: its text, where that is beyond doubt.
    """

    problem: str
    whole: str | None = None


def is_stray(text: str, rest: str) -> bool:
    """Whether what should be a key is a quantity, and no colon follows it.

    Args:
        text: in place of the key.
        rest: of its line.
    """
    begins = text.lstrip("+-.")[:1]
    return begins.isdigit() and rest.lstrip()[:1] in (",", "}")


def explain(key: str, value: Node, strays: Sequence[Stray]) -> Cut:
    """The value that a key's value and the quantities behind it probably are."""
    parts = [_shown(value), *(stray.text for stray in strays)]
    row = f"[{', '.join(parts)}]"
    if len(parts) != 2 or not _are_halves(value.value, parts[1]):
        return Cut(f"a list is written in brackets; write '{key}: {row}'")
    whole = ".".join(parts)
    if _is_tight(value.place, strays[0].place):
        return Cut(_decimal(*parts), whole)
    return Cut(f"a ',' ends the value; write '{key}: {whole}', or '{key}: {row}' for a list")


def decimal_comma(node: Node) -> str | None:
    """Message about a list in which a comma without a space cuts a number in two."""
    items = node.value if isinstance(node.value, list) else []
    for one, other in pairwise(items):
        if _is_tight(one.place, other.place) and _are_halves(one.value, str(other.value)):
            return _decimal(str(one.value), str(other.value))
    return None


def _shown(value: Node) -> str:
    """The text of a value, with the contents of collections left out."""
    if isinstance(value.value, list):
        return "[...]"
    return "{...}" if isinstance(value.value, dict) else str(value.value)


def _are_halves(whole: object, rest: str) -> bool:
    """Whether two values may be what is in front of a decimal point and what is behind it."""
    return isinstance(whole, int) and rest[:1].isdigit()


def _is_tight(one: Place, other: Place) -> bool:
    """Whether nothing but the comma is between two values."""
    return (one.line, one.end_column + 1) == (other.line, other.column)


def _decimal(whole: str, rest: str) -> str:
    return f"'{whole},{rest}' has a decimal comma; write '{whole}.{rest}'"

"""Quantities in braces that have no key, because a comma ended the value before them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cbdsl.errors.diagnostic import Place
from cbdsl.yaml_text.node import Node


class Stray(NamedTuple):
    """A quantity where a key should be."""

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
    """What a key's value and the quantities behind it were meant to be."""
    parts = [str(value.value), *(stray.text for stray in strays)]
    row = f"[{', '.join(parts)}]"
    is_number = isinstance(value.value, int) and len(parts) == 2 and parts[1][0].isdigit()
    if not is_number:
        return Cut(f"a list is written in brackets; write '{key}: {row}'")
    whole = ".".join(parts)
    if strays[0].place.column == value.place.end_column + 1:
        comma = ",".join(parts)
        return Cut(f"'{comma}' has a decimal comma; write '{whole}'", whole)
    return Cut(f"a ',' ends the value; write '{key}: {whole}', or '{key}: {row}' for a list")

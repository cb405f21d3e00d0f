"""Numbers with their nouns, as messages say them."""

from __future__ import annotations

from collections.abc import Sequence


def count(number: int, noun: str) -> str:
    """``1 joint``, ``2 joints``, ``no joints``."""
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def some(names: Sequence[str], most: int = 3) -> str:
    """The first of several names, and how many more there are: ``a, b, c and 2 more``."""
    others = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + others

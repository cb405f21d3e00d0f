"""Numbers with their nouns, for messages."""

from __future__ import annotations

from collections.abc import Sequence


def count(number: int, noun: str) -> str:
    """Return a number with its noun: ``1 joint``, ``2 joints``, ``no joints``."""
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def some(names: Sequence[str], most: int = 3) -> str:
    """Return the first of several names and the number of others: ``a, b, c and 2 more``."""
    others = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + others

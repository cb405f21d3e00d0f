"""Numbers with their nouns, as messages say them."""

from __future__ import annotations


def count(number: int, noun: str) -> str:
    """``1 joint``, ``2 joints``, ``no joints``."""
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"

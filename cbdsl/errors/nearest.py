"""The name that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

# Nobody names anything at greater length, and comparing takes the square of it.
_LONGEST = 60
# Each of a great many wrong names would be compared with each of a great many right ones.
_MOST = 500


def nearest_name(name: str, names: Iterable[str]) -> str | None:
    """The most similar of ``names``, or ``None`` where none is similar."""
    from difflib import get_close_matches  # only a fault needs it

    known = [known for known in islice(names, _MOST) if len(known) <= _LONGEST]
    matches = get_close_matches(name, known, n=1) if len(name) <= _LONGEST else []
    return matches[0] if matches else None


def suggestion(name: str, names: Iterable[str]) -> str:
    """The question with which a message goes on, if one of ``names`` is similar."""
    nearest = nearest_name(name, names)
    return f"; did you mean '{nearest}'?" if nearest else ""

"""Nearest allowed name to a misspelled one."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

# Real names are shorter; the time of a comparison grows with the square of the length.
_LONGEST = 60
# Limit of the comparisons, if many wrong names meet many right ones.
_MOST = 500


def nearest_name(name: str, names: Iterable[str]) -> str | None:
    """Return the most similar of ``names``, or ``None`` if none is similar."""
    from difflib import get_close_matches  # only a fault needs it

    # `difflib` rates similarity by matching blocks, from 0 to 1; its default bound is 0.6.
    known = [known for known in islice(names, _MOST) if len(known) <= _LONGEST]
    matches = get_close_matches(name, known, n=1) if len(name) <= _LONGEST else []
    return matches[0] if matches else None


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return the question that ends a message if one of ``names`` is similar; else empty."""
    nearest = nearest_name(name, names)
    return f"; did you mean '{nearest}'?" if nearest else ""

"""The name that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable


def nearest_name(name: str, names: Iterable[str]) -> str | None:
    """The most similar of ``names``, or ``None`` where none is similar."""
    from difflib import get_close_matches  # only a fault needs it

    matches = get_close_matches(name, list(names), n=1)
    return matches[0] if matches else None

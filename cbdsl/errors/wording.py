"""Findings in the catalogue's words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cbdsl.errors.diagnostic import Diagnostic, Place, Related
from cbdsl.errors.nearest import nearest_name


def diagnostic(
    code: str,
    place: Place,
    *,
    names: Sequence[str] = (),
    candidates: Sequence[str] = (),
    related: Iterable[tuple[Place, str]] = (),
    **details: object,
) -> Diagnostic:
    """A finding in the catalogue's words.

    Args:
        code: its entry.
        place: where it is.
        names: names that would have been right; the nearest to ``name`` or ``key`` is proposed.
        candidates: what the nearest is chosen from, where that is not ``names``.
        related: other places, and what is there.
        details: what the entry's message is filled with.
    """
    from cbdsl.errors.catalogue import CATALOGUE  # only a fault needs it

    entry = CATALOGUE[code]
    given = str(details.get("name", details.get("key", "")))
    return Diagnostic(
        code=code,
        message=entry.message.format(**details),
        place=place,
        severity=entry.severity,
        allowed=tuple(names),
        nearest=nearest_name(given, candidates or names),
        related=tuple(Related(where, message) for where, message in related),
    )

"""Findings in the catalogue's words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from cbdsl.errors.diagnostic import Diagnostic, Place, Related
from cbdsl.errors.legible import legible

if TYPE_CHECKING:
    from cbdsl.errors.entry import Entry


def diagnostic(
    code: str | Entry,
    place: Place,
    *,
    names: Sequence[str] = (),
    candidates: Sequence[str] = (),
    given: str | None = None,
    related: Iterable[tuple[Place, str]] = (),
    **details: object,
) -> Diagnostic:
    """A finding in the catalogue's words.

    Args:
        code: its entry, or the code of one in the catalogue.
        place: where it is.
        names: names that would have been right; the nearest to ``given`` is proposed.
        candidates: what the nearest is chosen from, where that is not ``names``.
        given: the name that was written instead; ``name`` or ``key`` of the details without it.
        related: other places, and what is there.
        details: what the entry's message is filled with.
    """
    from cbdsl.errors.catalogue import hundred  # only a fault needs it

    entry = hundred(code)[code] if isinstance(code, str) else code
    return Diagnostic(
        code=entry.code,
        message=legible(entry.message.format(**details)),
        place=place,
        severity=entry.severity,
        allowed=tuple(names),
        given=str(details.get("name", details.get("key", ""))) if given is None else given,
        candidates=tuple(candidates),
        related=tuple(Related(where, legible(message)) for where, message in related),
    )

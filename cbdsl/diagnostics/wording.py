"""Diagnostics with the messages of the catalogue."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Related
from cbdsl.diagnostics.legible_text import legible

if TYPE_CHECKING:
    from cbdsl.diagnostics.entry import Entry


def diagnose(
    code: str | Entry,
    place: Place,
    *,
    names: Sequence[str] = (),
    candidates: Sequence[str] = (),
    given: str | None = None,
    related: Iterable[tuple[Place, str]] = (),
    **details: object,
) -> Diagnostic:
    """Return a diagnostic with the message of a catalogue entry.

    Args:
        code: Catalogue entry, or its code.
        place: Place in a file.
        names: Allowed names; the nearest to ``given`` is proposed.
        candidates: Names from which the nearest is chosen; empty for ``names``.
        given: Name that was written instead; ``None`` for ``name`` or ``key`` of the details.
        related: Other places, each with a message.
        details: Values that fill the placeholders of the entry's message.
    """
    from cbdsl.diagnostics.catalogue import hundred  # only a fault needs it

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

"""Collection of the diagnostics of one pass."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Related
from cbdsl.diagnostics.wording import diagnose

if TYPE_CHECKING:
    from cbdsl.diagnostics.entry import Entry

# These have their cause in one place, but may occur in many: a missing name, for example, or a
# missing action.
_REPEATED = frozenset(
    {"CB114", "CB308", "CB351", "CB402", "CB404", "CB407", "CB501", "CB607", "CB608", "CB611"}
    | {"CB612", "CB613", "CB631", "CB717"}
)
# More places give no further information.
_MOST_PLACES = 6


class Diagnostics:
    """All diagnostics so far, each once, in the order of discovery.

    Attributes:
        added: Number of additions, with repeated ones.
    """

    def __init__(self) -> None:
        self._diagnostics: dict[Diagnostic, None] = {}
        self.added = 0

    def add(self, code: str | Entry, place: Place, **details: Any) -> None:
        """Add a diagnostic in the catalogue's words; see ``diagnose``."""
        self.extend([diagnose(code, place, **details)])

    def extend(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Add diagnostics of another collection."""
        new = list(diagnostics)
        self._diagnostics.update(dict.fromkeys(new))
        self.added += len(new)

    @property
    def failed(self) -> bool:
        """True if there is an error among them."""
        return any(diagnostic.is_error for diagnostic in self._diagnostics)

    def holds(self, codes: Collection[str]) -> bool:
        """Return whether there is a diagnostic with one of some codes."""
        return any(diagnostic.code in codes for diagnostic in self._diagnostics)

    def sorted(self) -> tuple[Diagnostic, ...]:
        """Return all diagnostics by place; a repeated one occurs once, with its other places."""
        firsts: dict[tuple[str, str, str], Diagnostic] = {}
        places: dict[Diagnostic, list[Place]] = {}
        for diagnostic in sorted(self._diagnostics, key=attrgetter("place", "code")):
            # All resources whose names have the same unknown first part are missing for one cause.
            what = diagnostic.given if diagnostic.code == "CB501" else diagnostic.message
            key = (diagnostic.place.file, diagnostic.code, what)
            is_repeated = diagnostic.code in _REPEATED
            first = firsts.setdefault(key, diagnostic) if is_repeated else diagnostic
            others = places.setdefault(first, [])
            # The same diagnostic may arrive twice, with and without its other places.
            known = (first.place, *(related.place for related in first.related))
            if diagnostic.place not in known:
                others.append(diagnostic.place)
        return tuple(_with(first, others) for first, others in places.items())


def _with(diagnostic: Diagnostic, others: list[Place]) -> Diagnostic:
    """Return a diagnostic with its other places as related ones."""
    if not others:
        return diagnostic
    related = [Related(place, "and here") for place in others[:_MOST_PLACES]]
    if more := len(others) - len(related):
        related[-1] = related[-1]._replace(message=f"and here, and in {count(more, 'more place')}")
    return diagnostic._replace(related=(*diagnostic.related, *related))

"""Collection of the diagnostics of one pass."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING, Any

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Diagnostic, Place, Related
from cbdsl.diagnostics.wording import diagnostic

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


class Findings:
    """All findings so far, each once, in the order of discovery.

    Attributes:
        added: Number of additions, with repeated ones.
    """

    def __init__(self) -> None:
        self._diagnostics: dict[Diagnostic, None] = {}
        self.added = 0

    def add(self, code: str | Entry, place: Place, **details: Any) -> None:
        """Add a finding in the catalogue's words; see ``diagnostic``."""
        self.extend([diagnostic(code, place, **details)])

    def extend(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Add findings of another collection."""
        new = list(diagnostics)
        self._diagnostics.update(dict.fromkeys(new))
        self.added += len(new)

    @property
    def failed(self) -> bool:
        """True if there is an error among them."""
        return any(finding.is_error for finding in self._diagnostics)

    def holds(self, codes: Collection[str]) -> bool:
        """Return whether there is a finding with one of some codes."""
        return any(finding.code in codes for finding in self._diagnostics)

    def sorted(self) -> tuple[Diagnostic, ...]:
        """Return all findings by place; a repeated one occurs once, with its other places."""
        firsts: dict[tuple[str, str, str], Diagnostic] = {}
        places: dict[Diagnostic, list[Place]] = {}
        for finding in sorted(self._diagnostics, key=lambda finding: (finding.place, finding.code)):
            # All resources whose names have the same unknown first part are missing for one cause.
            what = finding.given if finding.code == "CB501" else finding.message
            key = (finding.place.file, finding.code, what)
            first = firsts.setdefault(key, finding) if finding.code in _REPEATED else finding
            others = places.setdefault(first, [])
            # The same finding may arrive twice, with and without its other places.
            known = (first.place, *(related.place for related in first.related))
            if finding.place not in known:
                others.append(finding.place)
        return tuple(_with(first, others) for first, others in places.items())


def _with(finding: Diagnostic, others: list[Place]) -> Diagnostic:
    """Return a finding with its other places as related ones."""
    if not others:
        return finding
    related = [Related(place, "and here") for place in others[:_MOST_PLACES]]
    if more := len(others) - len(related):
        related[-1] = related[-1]._replace(message=f"and here, and in {count(more, 'more place')}")
    return finding._replace(related=(*finding.related, *related))

"""States and patterns of states: one letter per controller or program (Eq 4.1)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import StrEnum


class Predicate(StrEnum):
    """Four-valued state of a controller; its letters join into states such as ``X0-``."""

    INACTIVE = "X"
    UNDEFINED = "-"
    TRANSIENT = "0"
    QUIESCENT = "1"


PREDICATES = "".join(Predicate)
#: Wildcard of patterns: any predicate.
ANY = "*"
#: Regular expression of a state.
STATE = r"^[X01-]+$"


def matches(pattern: str, state: str) -> bool:
    """Return whether a state, or all states of a pattern, match a pattern of the same length."""
    return all(letter in (ANY, own) for letter, own in zip(pattern, state, strict=True))


def at_rest_anew(before: str, after: str) -> bool:
    """Return whether a member is quiescent in the later state but not in the earlier one."""
    rest = Predicate.QUIESCENT
    return any(now == rest != then for then, now in zip(before, after, strict=True))


def overlap(one: str, other: str) -> str | None:
    """Return the pattern of the states that match two patterns, or ``None`` for no such state."""
    letters = []
    for a, b in zip(one, other, strict=True):
        if a != b and ANY not in (a, b):
            return None
        letters.append(b if a == ANY else a)
    return "".join(letters)


# Patterns are boxes in the product of the members' letters. The rest of one box outside of another
# is a union of disjoint boxes, which repeated splits find one letter at a time.
def split(region: str, pattern: str) -> Iterator[str]:
    """Yield parts of a region, one per predicate at the first place that only the pattern fixes.

    A region is a pattern, too. A part with another predicate at this place shares no state with
    the pattern. If the pattern fixes no more places than the region, no part is yielded.
    """
    pairs = enumerate(zip(region, pattern, strict=True))
    place = next((i for i, (own, letter) in pairs if own == ANY != letter), None)
    if place is not None:
        for letter in PREDICATES:
            yield region[:place] + letter + region[place + 1 :]


def closest_first(patterns: Iterable[str]) -> list[str]:
    """Return patterns sorted by their number of wildcards; the first match of a state applies."""
    # The sort is stable: equally close patterns keep the order of the document.
    return sorted(patterns, key=lambda pattern: pattern.count(ANY))

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
#: Letters of patterns for a member at rest within its tolerance, and beyond it; 1 stands for both.
ARRIVED, STUCK = "a", "s"
#: Letters that a member of a running step may have: s at rest beyond its tolerance, 1 within it.
LETTERS = "-01s"
_SEVERAL = {ANY: "X-0as", Predicate.QUIESCENT.value: ARRIVED + STUCK}
#: Regular expression of a state.
STATE = r"^[X01-]+$"


def matches(pattern: str, state: str) -> bool:
    """Return whether a state, or all states of a pattern, match a pattern of the same length."""
    return all(
        own == letter or letter == ANY or own in _SEVERAL.get(letter, "")
        for letter, own in zip(pattern, state, strict=True)
    )


def outside(letter: str, other: str) -> list[str]:
    """Return letters for all predicates that one letter of a pattern has, and another one lacks."""
    rest = [own for own in _SEVERAL.get(letter, letter) if own not in _SEVERAL.get(other, other)]
    if ARRIVED in rest and STUCK in rest:
        rest = [*(own for own in rest if own not in (ARRIVED, STUCK)), Predicate.QUIESCENT.value]
    return rest


def tells_rest(patterns: Iterable[str]) -> bool:
    """Return whether patterns distinguish rest within a tolerance from rest beyond it."""
    return any(ARRIVED in pattern or STUCK in pattern for pattern in patterns)


def at_rest_anew(before: str, after: str) -> bool:
    """Return whether a member is quiescent in the later state but not in the earlier one."""
    rest = Predicate.QUIESCENT
    return any(now == rest != then for then, now in zip(before, after, strict=True))


def overlap(one: str, other: str) -> str | None:
    """Return the pattern of the states that match two patterns, or ``None`` for no such state."""
    letters = []
    for a, b in zip(one, other, strict=True):
        if a == b or b == ANY or a in _SEVERAL.get(b, ""):
            letters.append(a)
        elif a == ANY or b in _SEVERAL.get(a, ""):
            letters.append(b)
        else:
            return None
    return "".join(letters)


# Patterns are boxes in the product of the members' letters. The rest of one box outside of another
# is a union of disjoint boxes, which repeated splits find one letter at a time.
def split(region: str, pattern: str) -> Iterator[str]:
    """Yield parts of a region, one per predicate at the first place that only the pattern fixes.

    A region is a pattern, too. A part with another predicate at this place shares no state with
    the pattern. If the pattern fixes no more places than the region, no part is yielded.
    """
    pairs = enumerate(zip(region, pattern, strict=True))
    place = next((i for i, (own, letter) in pairs if own != letter and matches(own, letter)), None)
    if place is not None:
        letters = PREDICATES if region[place] == ANY else ARRIVED + STUCK
        for letter in letters:
            yield region[:place] + letter + region[place + 1 :]


def closest_first(patterns: Iterable[str]) -> list[str]:
    """Return patterns sorted by their number of wildcards; the first match of a state applies."""
    # The sort is stable: equally close patterns keep the order of the document.
    return sorted(patterns, key=lambda pattern: pattern.count(ANY))

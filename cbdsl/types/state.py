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
    """Whether a state matches a pattern of the same length; of a pattern, all of its states."""
    return all(letter in (ANY, own) for letter, own in zip(pattern, state, strict=True))


def at_rest_anew(before: str, after: str) -> bool:
    """Whether a member is at rest in the later of two states that was not so in the earlier."""
    rest = Predicate.QUIESCENT
    return any(now == rest != then for then, now in zip(before, after, strict=True))


def overlap(one: str, other: str) -> str | None:
    """Pattern of the states that match both of two patterns, ``None`` where there are none."""
    letters = []
    for a, b in zip(one, other, strict=True):
        if a != b and ANY not in (a, b):
            return None
        letters.append(b if a == ANY else a)
    return "".join(letters)


def split(region: str, pattern: str) -> Iterator[str]:
    """Parts of a region, one per predicate at the first place that only the pattern fixes.

    A region is a pattern, too. The part that differs from the pattern there has no state in common
    with it; where the pattern fixes no more than the region, there is nothing to split.
    """
    pairs = enumerate(zip(region, pattern, strict=True))
    place = next((i for i, (own, letter) in pairs if own == ANY != letter), None)
    if place is not None:
        for letter in PREDICATES:
            yield region[:place] + letter + region[place + 1 :]


def closest_first(patterns: Iterable[str]) -> list[str]:
    """Patterns by their number of wildcards: the first that matches a state decides it."""
    return sorted(patterns, key=lambda pattern: pattern.count(ANY))

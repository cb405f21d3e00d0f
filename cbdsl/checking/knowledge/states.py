"""State patterns of a policy: letters, lengths and contradictions (Eq 4.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Outcome, Unknown
from cbdsl.types.state import ANY, PREDICATES, matches, overlap, split
from cbdsl.yaml_text.source_map import SourceMap

# A pattern is a box: the product of one set of letters per member, with all four letters for a
# star. A state is decided by the matching patterns with the fewest stars. Two patterns with equally
# many stars contradict each other if they choose different actions for a state that no closer
# pattern decides. A pattern is idle if closer patterns cover its whole box. Whether boxes cover a
# box is the tautology problem of a disjunctive normal form, which is co-NP-complete. A budget of
# splits therefore bounds the search. When it ends, the rest is left without a diagnostic, since a
# false one would be worse.

# Letters that are easily mistaken for the letter of a predicate, with the intended letter.
_MEANT = {"x": "X", "o": "0", "O": "0", "l": "1", "I": "1", "_": "-", "?": ANY}
# Enough for each policy written by hand; a malicious document needs any number.
_MOST_SPLITS = 1_000
_MOST_LETTERS = 1_000_000


def check_states(
    policy: Mapping[str, str],
    members: Outcome[Sequence[str]],
    source: SourceMap,
    diagnostics: Diagnostics,
) -> None:
    """Check the patterns of a policy.

    Args:
        policy: Canonical action by pattern.
        members: Predicates that the letters of a state stand for.
        source: Source map of the policy.
        diagnostics: Diagnostics so far.
    """
    sound = {
        pattern: action
        for pattern, action in policy.items()
        if is_sound(pattern, members, source.key("policy", pattern), diagnostics)
    }
    # A pattern that was left out, or is invalid, may decide between others.
    known = source.known(policy, "policy")
    if isinstance(members, Unknown) or isinstance(known, Unknown) or len(sound) < len(known):
        return
    patience, contradict = _Patience(_MOST_SPLITS), False
    for other, one, example in _contradictions(sound, patience):
        first = (source.key("policy", one), f"'{one}' is here")
        place = source.key("policy", other)
        details = {"state": other, "other": one, "example": example}
        diagnostics.add("CB614", place, related=[first], **details)
        contradict = True
    for pattern in () if contradict else _idle(sound, patience):
        diagnostics.add("CB707", source.key("policy", pattern), state=pattern)


def _contradictions(
    sound: Mapping[str, str], patience: _Patience
) -> Iterator[tuple[str, str, str]]:
    """Yield each pattern that contradicts an earlier one, the earlier one, and a shared state."""
    # Only equally close patterns can contradict each other, since a closer one always decides.
    equally_close: dict[int, list[str]] = {}
    for pattern in sound:
        equally_close.setdefault(pattern.count(ANY), []).append(pattern)
    for stars, patterns in equally_close.items():
        closer = [p for fewer, ps in equally_close.items() if fewer < stars for p in ps]
        sets = {pattern: _bits(pattern) for pattern in patterns}
        ones = _ones(len(patterns[0]))
        for i, other in enumerate(patterns):
            for one in patterns[:i]:
                if sound[one] == sound[other] or not _meet(sets[one], sets[other], ones):
                    continue
                both = overlap(one, other)
                example = _left_over(both, closer, patience) if both is not None else None
                if example is not None:
                    yield other, one, example
                    break


def _idle(sound: Mapping[str, str], patience: _Patience) -> Iterator[str]:
    """Yield the patterns whose states are all decided by patterns with fewer stars."""
    open_ones = [pattern for pattern in sound if ANY in pattern]
    if len(open_ones) * sum(len(pattern) for pattern in sound) > _MOST_LETTERS:
        return
    sets = {pattern: (_bits(pattern), pattern.count(ANY)) for pattern in sound}
    for pattern in open_ones:
        bits, stars = sets[pattern]
        ones = _ones(len(pattern))
        closer = [p for p, (own, fewer) in sets.items() if fewer < stars and _meet(own, bits, ones)]
        if closer and _left_over(pattern, closer, patience) is None and not patience.has_ended:
            yield pattern


def is_sound(
    pattern: str, members: Outcome[Sequence[str]], place: Place, diagnostics: Diagnostics
) -> bool:
    """Return whether a pattern has a known letter for each member, and report errors.

    Args:
        pattern: Pattern of states.
        members: Predicates that the letters stand for.
        place: Place of the pattern.
        diagnostics: Diagnostics so far.
    """
    wrong = [letter for letter in pattern if letter not in PREDICATES + ANY]
    if wrong:
        suggestion = _MEANT.get(wrong[0])
        hint = f"; did you mean '{suggestion}'?" if suggestion else ""
        diagnostics.add("CB612", place, letter=wrong[0], meant=hint)
        return False
    if not isinstance(members, Unknown) and len(pattern) != len(members):
        counts = {
            "found": count(len(pattern), "letter"),
            "wanted": count(len(members), "predicate"),
        }
        diagnostics.add("CB611", place, members=", ".join(members), **counts)
        return False
    return True


# Large integers compare all letters of two patterns in a few operations. A document may have
# thousands of pairs of patterns, and most pairs have no state in common.
def _bits(pattern: str) -> int:
    """Return a pattern as a number of four bits per letter, one for each letter that it allows."""
    bits = 0
    for letter in pattern:
        bits = bits << 4 | (15 if letter == ANY else 1 << PREDICATES.index(letter))
    return bits


def _ones(letters: int) -> int:
    return int("1" * letters, 16)


def _meet(one: int, other: int, ones: int) -> bool:
    """Return whether some state matches both patterns: each letter has a bit in common."""
    # The shifts fold the four bits of each letter onto its lowest bit. Bits from the next group end
    # above the lowest bit, where the mask removes them.
    both = one & other
    return (both | both >> 1 | both >> 2 | both >> 3) & ones == ones


class _Patience:
    """Budget of splits of a region, because the cover of a region by others is a hard problem."""

    def __init__(self, splits: int) -> None:
        self._splits = splits

    @property
    def has_ended(self) -> bool:
        """True if there have been too many splits."""
        return self._splits < 0

    def ends(self) -> bool:
        """Count a split, and return whether there have been too many."""
        self._splits -= 1
        return self.has_ended


def _left_over(region: str, covers: Sequence[str], patience: _Patience) -> str | None:
    """Return a part of a region that no cover touches, or ``None`` if they cover all of it.

    When patience ends, the region counts as covered.
    """
    if patience.ends():
        return None
    # Covers that do not touch the region cannot touch its parts either, so that lists get shorter.
    touching = [cover for cover in covers if overlap(region, cover) is not None]
    if not touching:
        return region
    if any(matches(cover, region) for cover in touching):
        return None
    # Some cover fixes a letter that the region leaves open: split the region there.
    parts = (_left_over(part, touching, patience) for part in split(region, touching[0]))
    return next((part for part in parts if part is not None), None)

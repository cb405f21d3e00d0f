"""State patterns of a policy: letters, lengths and contradictions (Eq 4.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

from cbdsl.checking.findings import Findings
from cbdsl.errors.counting import count
from cbdsl.yaml_text.source_map import SourceMap

PREDICATES = "X-01"
ANY = "*"


def check_states(
    policy: Mapping[str, str], members: Sequence[str], source: SourceMap, findings: Findings
) -> None:
    """Check the patterns of a policy, given as canonical action by pattern."""
    sound = {
        pattern: action
        for pattern, action in policy.items()
        if _is_sound(pattern, members, source, findings)
    }
    for one, other in combinations(sound, 2):
        if sound[one] == sound[other] or one.count(ANY) != other.count(ANY):
            continue
        both = _overlap(one, other)
        closer = [pattern for pattern in sound if pattern.count(ANY) < one.count(ANY)]
        example = _left_over(both, closer) if both is not None else None
        if example is not None:
            first = (source.key("policy", one), f"'{one}' is here")
            place = source.key("policy", other)
            details = {"state": other, "other": one, "example": example}
            findings.add("CB614", place, related=[first], **details)


def _is_sound(pattern: str, members: Sequence[str], source: SourceMap, findings: Findings) -> bool:
    place = source.key("policy", pattern)
    wrong = [letter for letter in pattern if letter not in PREDICATES + ANY]
    if wrong:
        findings.add("CB612", place, letter=wrong[0], state=pattern)
    elif len(pattern) != len(members):
        counts = {
            "found": count(len(pattern), "letter"),
            "wanted": count(len(members), "predicate"),
        }
        findings.add("CB611", place, state=pattern, members=", ".join(members), **counts)
    return not wrong and len(pattern) == len(members)


def _overlap(one: str, other: str) -> str | None:
    """The pattern of the states that both patterns match, or ``None``."""
    letters = []
    for a, b in zip(one, other, strict=True):
        if a != b and ANY not in (a, b):
            return None
        letters.append(b if a == ANY else a)
    return "".join(letters)


def _left_over(region: str, covers: Sequence[str]) -> str | None:
    """A part of a region that no cover touches, or ``None`` where they cover all of it."""
    touching = [cover for cover in covers if _overlap(region, cover) is not None]
    if not touching:
        return region
    if any(_overlap(region, cover) == region for cover in touching):
        return None
    # Some cover fixes a letter that the region leaves open: split the region there.
    split = next(i for i, letter in enumerate(region) if letter == ANY and touching[0][i] != ANY)
    for letter in PREDICATES:
        part = _left_over(region[:split] + letter + region[split + 1 :], touching)
        if part is not None:
            return part
    return None

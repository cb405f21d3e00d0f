"""Patterns of states against an enumeration of all states."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.checking.knowledge.states import check_states
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.source_map import SourceMap

PATTERNS = st.lists(st.text("X-01**", min_size=2, max_size=2), min_size=1, max_size=9, unique=True)


def found(policy: dict[str, str]) -> dict[str, set[str]]:
    """Return the patterns that have diagnostics, by code."""
    text = "policy:\n" + "".join(f'  "{state}": {action}\n' for state, action in policy.items())
    diagnostics = Diagnostics()
    source = SourceMap(Path("p.yaml"), text.split("\n"), compose(text, "p.yaml").root)
    check_states(policy, ("a", "b"), source, diagnostics)
    lines = list(policy)
    by_code: dict[str, set[str]] = {}
    for diagnostic in diagnostics.sorted():
        by_code.setdefault(diagnostic.code, set()).add(lines[diagnostic.place.line - 2])
    return by_code


def closest(policy: dict[str, str], state: str) -> list[str]:
    """Return the matching patterns with the fewest stars."""
    matching = [p for p in policy if all(a in ("*", b) for a, b in zip(p, state, strict=True))]
    fewest = min((p.count("*") for p in matching), default=0)
    return [p for p in matching if p.count("*") == fewest]


@settings(deadline=None)
@given(PATTERNS)
def test_pattern_that_decides_no_state_is_idle(patterns: list[str]) -> None:
    policy = dict.fromkeys(patterns, "a")
    states = ["".join(pair) for pair in product("X-01", repeat=2)]
    deciding = {pattern for state in states for pattern in closest(policy, state)}
    assert found(policy).get("CB707", set()) == set(patterns) - deciding


@settings(deadline=None)
@given(PATTERNS, st.data())
def test_patterns_contradict_if_some_state_has_two_actions(
    patterns: list[str], data: st.DataObject
) -> None:
    policy = {pattern: data.draw(st.sampled_from("ab")) for pattern in patterns}
    states = ["".join(pair) for pair in product("X-01", repeat=2)]
    disputed = any(len({policy[p] for p in closest(policy, state)}) > 1 for state in states)
    assert ("CB614" in found(policy)) == disputed


@pytest.mark.parametrize("members", [40, 200])
def test_many_members_and_patterns_come_to_an_end(members: int) -> None:
    policy = {"*" * i + "X01-"[i % 4] + "*" * (members - i - 1): "a" for i in range(members)}
    policy |= {"*" * i + "XX" + "*" * (members - i - 2): "a" for i in range(members - 1)}
    text = "policy: {}\n"
    source = SourceMap(Path("p.yaml"), text.split("\n"), compose(text, "p.yaml").root)
    diagnostics = Diagnostics()
    check_states(policy, ["a"] * members, source, diagnostics)
    assert all(diagnostic.code == "CB707" for diagnostic in diagnostics.sorted())

"""Written policies: patterns, the closest of which applies."""

from __future__ import annotations

from itertools import product

import pytest

from cbdsl.runtime.policies.policy import Choice, WrittenPolicy


@pytest.mark.parametrize("turned", [False, True])
def test_most_specific_pattern_wins_in_any_order(turned: bool) -> None:
    table = {"**": "any", "X*": "first", "X1": "both"}
    items = list(table.items())
    policy = WrittenPolicy(dict(reversed(items) if turned else items))
    chosen = {
        state: policy.choose(state, changed=True).action
        for state in map("".join, product("X-01", "X-01"))
    }
    assert chosen.pop("X1") == "both"
    assert {chosen.pop(state) for state in ("XX", "X-", "X0")} == {"first"}
    assert set(chosen.values()) == {"any"}


def test_written_policy_ends_without_a_pattern_or_a_change() -> None:
    policy = WrittenPolicy({"0": "move"})
    assert policy.choose("1", changed=True) == Choice(None)
    assert policy.choose("0", changed=True) == Choice("move")
    assert policy.choose("0", changed=False) == Choice(None)

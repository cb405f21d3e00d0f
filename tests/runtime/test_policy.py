"""Written policies: patterns, the closest of which applies."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.runtime.policy import WILDCARD, WrittenPolicy, matches

STATES = st.text("X-01", min_size=1, max_size=5)


@given(STATES, st.data())
def test_a_state_fits_itself_with_any_letters_left_open(state: str, data: st.DataObject) -> None:
    hidden = data.draw(st.lists(st.booleans(), min_size=len(state), max_size=len(state)))
    pattern = "".join(WILDCARD if h else s for h, s in zip(hidden, state, strict=True))
    assert matches(pattern, state)


@given(STATES, st.data())
def test_one_other_letter_and_it_does_not_fit(state: str, data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(state) - 1))
    other = data.draw(st.sampled_from(sorted(set("X-01") - {state[place]})))
    assert not matches(state[:place] + other + state[place + 1 :], state)


def test_a_pattern_of_another_length_is_a_fault() -> None:
    with pytest.raises(ValueError, match="shorter"):
        matches("X*", "X")


@pytest.mark.parametrize("turned", [False, True])
def test_the_most_specific_pattern_wins_in_whatever_order_they_are_written(turned: bool) -> None:
    table = {"**": "any", "X*": "first", "X1": "both"}
    items = list(table.items())
    policy = WrittenPolicy(dict(reversed(items) if turned else items))
    chosen = {
        state: policy.choose(state, changed=True) for state in map("".join, product("X-01", "X-01"))
    }
    assert chosen.pop("X1") == "both"
    assert {chosen.pop(state) for state in ("XX", "X-", "X0")} == {"first"}
    assert set(chosen.values()) == {"any"}


def test_it_ends_where_no_pattern_fits_and_where_nothing_changed() -> None:
    policy = WrittenPolicy({"0": "move"})
    assert policy.choose("1", changed=True) is None
    assert policy.choose("0", changed=True) == "move"
    assert policy.choose("0", changed=False) is None

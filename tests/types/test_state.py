"""States and patterns, against brute force over all of them up to three letters."""

from __future__ import annotations

import re
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.reporting.drawing.pictogram import LETTERS
from cbdsl.types.state import ANY, PREDICATES, STATE, closest_first, matches, overlap, split

LENGTHS = (1, 2, 3)
LONG = st.text("X-01", min_size=1, max_size=8)


def _words(alphabet: str, length: int) -> list[str]:
    return ["".join(letters) for letters in product(alphabet, repeat=length)]


def _states(pattern: str) -> frozenset[str]:
    """Return states of a pattern, spelled out."""
    choices = [PREDICATES if letter == ANY else letter for letter in pattern]
    return frozenset("".join(letters) for letters in product(*choices))


PATTERNS = {
    length: {pattern: _states(pattern) for pattern in _words(PREDICATES + ANY, length)}
    for length in LENGTHS
}


@pytest.mark.parametrize("length", LENGTHS)
def test_pattern_matches_its_states_and_the_patterns_within(length: int) -> None:
    for pattern, states in PATTERNS[length].items():
        assert {state for state in _words(PREDICATES, length) if matches(pattern, state)} == states
        for other, others in PATTERNS[length].items():
            assert matches(pattern, other) == (others <= states)


@pytest.mark.parametrize("length", LENGTHS)
def test_overlap_holds_the_states_of_both(length: int) -> None:
    for one, ones in PATTERNS[length].items():
        for other, others in PATTERNS[length].items():
            both = overlap(one, other)
            assert both == overlap(other, one)
            assert (_states(both) if both is not None else frozenset()) == ones & others


@pytest.mark.parametrize("length", LENGTHS)
def test_split_parts_share_out_a_region(length: int) -> None:
    for region, states in PATTERNS[length].items():
        for pattern in PATTERNS[length]:
            parts = list(split(region, pattern))
            if matches(pattern, region) or not parts:
                assert not parts
                continue
            assert frozenset().union(*map(_states, parts)) == states
            assert sum(len(_states(part)) for part in parts) == len(states)
            assert sum(overlap(part, pattern) is not None for part in parts) <= 1


@given(LONG, st.data())
def test_state_matches_itself_with_any_letters_left_open(state: str, data: st.DataObject) -> None:
    hidden = data.draw(st.lists(st.booleans(), min_size=len(state), max_size=len(state)))
    pattern = "".join(ANY if h else s for h, s in zip(hidden, state, strict=True))
    assert matches(pattern, state)
    place = data.draw(st.integers(0, len(state) - 1))
    other = data.draw(st.sampled_from(sorted(set(PREDICATES) - {state[place]})))
    assert not matches(state[:place] + other + state[place + 1 :], state)


def test_patterns_of_another_length_are_a_fault() -> None:
    for compared in (matches, overlap):
        with pytest.raises(ValueError, match="shorter"):
            compared("X*", "X")


def test_closest_pattern_comes_first_and_equal_ones_stay_in_order() -> None:
    assert closest_first(["**", "1*", "X0", "*0"]) == ["X0", "1*", "*0", "**"]


def test_every_letter_has_a_pictogram_and_is_read_in_documents() -> None:
    assert set(LETTERS) == set(PREDICATES + ANY)
    assert {letter for letter in map(chr, range(128)) if re.match(STATE, letter)} == set(PREDICATES)

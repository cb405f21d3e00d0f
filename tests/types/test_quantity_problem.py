"""Invalid quantities are reported with a valid spelling."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.types.quantity_problem import is_quantity, problem_in, quantities_in, quantity_problem
from cbdsl.types.unit import UNITS, QuantityError, read_quantity

NUMBERS = st.decimals(-999, 999, places=2).map(str)
QUANTITIES = st.builds(lambda number, unit: f"{number} {unit}", NUMBERS, st.sampled_from([*UNITS]))
PHYSICAL = ("length", "angle", "time")


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ("20 cm,", "20 cm"),
        ("20 cm;", "20 cm"),
        ("20 cm# wide", "20 cm # wide"),
        ("20 cm // wide", "20 cm # wide"),
        ("2x10^-3 m", "2e-3 m"),
        ("pi", "180 deg"),
        ("-pi/2 rad", "-90 deg"),
        ("2*pi", "360 deg"),
        ("s 15", "15 s"),
        ("15 sec", "15 s"),
        ("90 degrees", "90 deg"),
        ("12 MM", "12 mm"),
        ("2 m/s2", "2 m/s^2"),
        ({"value": 15, "unit": "s"}, "15 s"),
        ([15, "s"], "15 s"),
        (["15 s"], "15 s"),
        ("0,5 m", "0.5 m"),
    ],
)
def test_misspelled_quantity_proposes_a_correction(value: object, written: str) -> None:
    with pytest.raises(QuantityError) as error:
        read_quantity(value, PHYSICAL)
    assert f"write '{written}'" in quantity_problem(value, error.value)
    assert is_quantity(written.partition(" #")[0])


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ("2 - 3 m", "[2 m, 3 m]"),
        ("2 cm to 1 m", "[2 cm, 1 m]"),
        ("2 - 1e3 m", "[2 m, 1e3 m]"),
        ("1e-3..2e-3 m", "[1e-3 m, 2e-3 m]"),
    ],
)
def test_problem_in_a_span_names_both_values_with_units(value: str, written: str) -> None:
    assert f"write {written}" in str(problem_in(value))


@pytest.mark.parametrize("value", ["fast", "5 bananas", "", None, [], {}, [1, 2, 3], "1 2 x"])
def test_text_without_a_quantity_has_no_problem(value: object) -> None:
    assert problem_in(value) is None


@given(st.lists(QUANTITIES, min_size=2, max_size=5), st.sampled_from(["[]", "()", "  "]))
def test_list_in_a_text_is_read(parts: list[str], brackets: str) -> None:
    text = f"{brackets[0]}{', '.join(parts)}{brackets[1]}"
    assert quantities_in(text) == parts
    assert problem_in(text) == f"a list is written in brackets; write [{', '.join(parts)}]"


@given(QUANTITIES, QUANTITIES, st.sampled_from([" - ", " to ", "..", "…"]))
def test_span_in_a_text_is_reported(first: str, second: str, between: str) -> None:
    said = problem_in(f"{first}{between}{second}")
    assert said is not None and re.search(r"write \[.*, .*\]$", said)


@given(QUANTITIES)
def test_quantity_is_no_list(text: str) -> None:
    assert quantities_in(text) == [text]

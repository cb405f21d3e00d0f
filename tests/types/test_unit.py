"""Quantities."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.types.unit import UNITS, QuantityError, parse_quantity, read_quantity


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(UNITS)))
def test_written_quantity_reads_as_its_si_value(number: float, symbol: str) -> None:
    unit = UNITS[symbol]
    assert parse_quantity(f"{number!r} {symbol}") == (number * unit.factor, unit)
    assert read_quantity(f"{number!r} {symbol}", (unit.dimension,)) == number * unit.factor


@given(st.text(max_size=8))
def test_any_text_is_a_quantity_or_an_error(text: str) -> None:
    try:
        assert math.isfinite(read_quantity(text, ("length",)))
    except QuantityError as error:
        assert "length" in str(error) or "finite" in str(error)


@pytest.mark.parametrize("value", [True, None, [1], float("inf"), float("nan"), 10**400, "1e999"])
def test_non_finite_quantity_is_an_error(value: object) -> None:
    with pytest.raises(QuantityError):
        read_quantity(value, ("length",))


def test_error_names_the_units_that_would_do() -> None:
    with pytest.raises(QuantityError, match=r"dimension force; expected length \(m, cm, mm, km\)"):
        read_quantity("2 N", ("length",))
    with pytest.raises(QuantityError, match=r"'metre' is not a unit; expected length"):
        read_quantity("2 metre", ("length",))

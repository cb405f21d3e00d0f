"""Joint limits, which are reported in the unit of the angle that violates them."""

from __future__ import annotations

import math

import pytest

from cbdsl.checking.robot.limits import limit_details
from cbdsl.types.unit import UNITS

ANGLES = [unit.symbol for unit in UNITS.values() if unit.dimension == "angle"]


@pytest.mark.parametrize("symbol", ANGLES)
def test_all_three_are_in_the_unit_that_is_written(symbol: str) -> None:
    factor = UNITS[symbol].factor
    told = limit_details(f"3 {symbol}", 3 * factor, (-1 * factor, 2 * factor))
    assert told == {"angle": "3", "lower": "-1", "upper": "2", "unit": symbol}


@pytest.mark.parametrize("written", [3, 3.0, "3", None])
def test_radians_where_no_unit_is_written(written: object) -> None:
    told = limit_details(written, 3.0, (-math.pi, 2.0))
    assert told == {"angle": "3", "lower": "-3.142", "upper": "2", "unit": "rad"}

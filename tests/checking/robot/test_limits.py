"""Joint limits, which are reported in the unit of the angle that violates them."""

from __future__ import annotations

import math

import pytest

from cbdsl.checking.robot.limits import limit_details
from cbdsl.types.unit import UNITS

ANGLES = [unit.symbol for unit in UNITS.values() if unit.dimension == "angle"]


@pytest.mark.parametrize("symbol", ANGLES)
def test_limit_details_are_in_the_written_unit(symbol: str) -> None:
    factor = UNITS[symbol].factor
    told = limit_details(f"3 {symbol}", 3 * factor, (-1 * factor, 2 * factor))
    assert told == {"angle": "3", "lower": "-1", "upper": "2", "unit": symbol}


@pytest.mark.parametrize("written", [3, 3.0, "3", None])
def test_limit_details_without_a_unit_are_in_radians(written: object) -> None:
    told = limit_details(written, 3.0, (-math.pi, 2.0))
    assert told == {"angle": "3", "lower": "-3.142", "upper": "2", "unit": "rad"}

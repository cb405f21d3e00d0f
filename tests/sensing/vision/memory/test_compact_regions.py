"""Regions that show one object, and regions of merged ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.vision.memory.merged_regions import is_compact

Booleans = NDArray[np.bool_]
X, Y = np.meshgrid(np.linspace(-20.0, 20.0, 801), np.linspace(-20.0, 20.0, 801))


def region(mask: Booleans) -> Region:
    """Return the region of the points of a mask."""
    x, y = X[mask], Y[mask]
    (xx, xy), (_, yy) = np.cov(x, y)
    moments = Moments(20.0**2 * xx, 20.0**2 * xy, 20.0**2 * yy)
    return Region(int(mask.sum()), 160.0, 120.0, False, moments)


def disc(x: float, radius: float) -> Booleans:
    within: Booleans = (X - x) ** 2 + Y**2 < radius**2
    return within


def bar(x: float, length: float, width: float, turn: float = 0.0) -> Booleans:
    along, across = np.cos(turn) * X + np.sin(turn) * Y, np.cos(turn) * Y - np.sin(turn) * X
    within: Booleans = (abs(along - x) < length / 2) & (abs(across) < width / 2)
    return within


@given(st.floats(3.0, 6.0), st.floats(0.5, 1.0))
def test_region_of_two_touching_discs_is_not_compact(radius: float, ratio: float) -> None:
    other = ratio * radius
    assert not is_compact(region(disc(-radius, radius) | disc(0.97 * other, other)))


@given(st.floats(0.0, 3.1))
def test_region_of_a_tool_with_parts_of_different_widths_is_compact(turn: float) -> None:
    hammer = bar(0.0, 20.0, 2.5, turn) | bar(11.0, 3.0, 9.0, turn)
    screwdriver = bar(-5.0, 10.0, 3.0, turn) | bar(5.0, 10.0, 0.8, turn)
    chisel = bar(-5.0, 11.0, 3.4, turn) | bar(5.0, 9.0, 1.2, turn)
    assert all(is_compact(region(tool)) for tool in (hammer, screwdriver, chisel))


@pytest.mark.parametrize("mask", [disc(0.0, 5.0), bar(0.0, 8.0, 8.0), bar(0.0, 30.0, 3.0)])
def test_region_of_a_disc_or_bar_is_compact(mask: Booleans) -> None:
    assert is_compact(region(mask))

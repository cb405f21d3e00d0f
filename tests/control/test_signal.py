"""Numbers that are not finite stop at the signal."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.obstacle import Obstacle
from cbdsl.control.signal import Signal, SignalError


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_non_finite_numbers_are_refused_by_name(bad: float) -> None:
    good, rows = np.zeros(3), np.zeros((3, 7))
    with pytest.raises(SignalError, match=r"value of stereo\.red"):
        Signal("stereo.red", np.array([0.0, bad, 0.0]), rows)
    spoiled = rows.copy()
    spoiled[1, 4] = bad
    with pytest.raises(SignalError, match=r"Jacobian of stereo\.red"):
        Signal("stereo.red", good, spoiled)


def test_jacobian_is_a_matrix() -> None:
    with pytest.raises(SignalError, match=r"stereo\.red has shape \(3,\)"):
        Signal("stereo.red", np.zeros(3), np.zeros(3))


def test_curvature_fits_the_jacobian_and_is_finite() -> None:
    value, rows = np.zeros(3), np.zeros((3, 7))
    assert Signal("tip", value, rows, np.zeros((3, 7, 7))).curvature is not None
    with pytest.raises(SignalError, match=r"curvature of tip has shape \(3, 7\)"):
        Signal("tip", value, rows, rows)
    spoiled = np.zeros((3, 7, 7))
    spoiled[2, 6, 0] = np.nan
    with pytest.raises(SignalError, match="curvature of tip is not finite"):
        Signal("tip", value, rows, spoiled)


@pytest.mark.parametrize("radius", [np.nan, np.inf])
def test_obstacles_are_finite(radius: float) -> None:
    ball = Obstacle.sphere("lamp", np.zeros(3), radius)
    with pytest.raises(SignalError, match="obstacle lamp is not finite"):
        Signal("tip", np.zeros(3), np.zeros((3, 7)), obstacles=(ball,))

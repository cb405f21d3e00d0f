"""Lines of sight: how far a point is from one, and how large a ball there would have to be."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cbdsl.sensing.channels import Region
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.association.stereo import Ray

ORIGIN = np.array([0.1, -0.2, 0.3])
ALONG = np.array([2.0, 1.0, -2.0])  # of length 3
ASIDE = np.array([1.0, 0.0, 1.0]) / math.sqrt(2)  # across it


def sighting(area: int = 314, scale: float = 1.0) -> Sighting:
    region = Region(area, 80.0, 60.0, False, (0.0, 0.0, 0.0), None)  # type: ignore[arg-type]
    return Sighting(region, Ray(ORIGIN, ALONG, 3.0), scale, 200.0, 0.0, 1)


@pytest.mark.parametrize("ahead", [1e-3, 0.7, 5.0])
@pytest.mark.parametrize("aside", [0.0, 0.04, -0.5])
def test_distance_is_that_across_the_line(ahead: float, aside: float) -> None:
    point = ORIGIN + ahead * ALONG + aside * ASIDE
    assert sighting().distance(point) == pytest.approx(abs(aside), abs=1e-7)


def test_point_behind_or_beside_the_camera_has_infinite_distance() -> None:
    assert sighting().distance(ORIGIN - 0.1 * ALONG) == math.inf
    assert sighting().distance(ORIGIN) == math.inf


def test_ball_twice_as_far_is_twice_as_large() -> None:
    """Discs of 314 px have a radius of 10 px, which is 1 m at 20 m and with 200 px for 1 m."""
    near = sighting().radius(ORIGIN + 20.0 * ALONG / 3.0)
    assert near == pytest.approx(math.sqrt(314 / math.pi) / 10)
    assert sighting().radius(ORIGIN + 40.0 * ALONG / 3.0) == pytest.approx(2 * near)
    assert sighting(scale=0.25).radius(ORIGIN + 20.0 * ALONG / 3.0) == pytest.approx(near / 2)

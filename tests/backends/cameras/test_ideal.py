"""Regions that the ideal cameras report."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping

import cv2
import numpy as np
import pytest

from cbdsl.backends.cameras.ideal import _connected
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.channels import Moments, Region, Regions, connected_regions
from tests.backends.conftest import URDF, exact, stage_named

Reported = Mapping[str, Mapping[str, Regions]]


def _reported(backend: KinematicBackend, channels: Collection[str] | None) -> list[Reported]:
    """Return the regions of an episode's first images."""
    stage = stage_named("moving_right")
    backend.reset(stage, None, np.random.default_rng(1), channels)
    found = []
    for _ in range(20):
        found.append(backend.observe().regions)
        backend.step()
    return found


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument) -> KinematicBackend:
    return KinematicBackend(exact(dexter), URDF)


@pytest.mark.parametrize("channels", [{"sat_10"}, {"motion"}, {"hue_7", "motion"}, ()])
def test_only_requested_channels_are_reported(
    backend: KinematicBackend, channels: Collection[str]
) -> None:
    everything = _reported(backend, None)
    names = {name for regions in everything for found in regions.values() for name in found}
    assert names > {"sat_10", "motion"}
    wanted = [
        {
            camera: {name: region for name, region in found.items() if name in channels}
            for camera, found in regions.items()
        }
        for regions in everything
    ]
    assert _reported(backend, channels) == wanted


def region(column: float, radius: float) -> Region:
    """Return the region of a ball."""
    spread = radius**2 / 4
    return Region(round(math.pi * radius**2), column, 50.0, False, Moments(spread, 0.0, spread))


def test_silhouettes_that_touch_are_one_region_as_in_an_image() -> None:
    image = np.zeros((100, 200), np.uint8)
    for column, radius in ((50, 20), (85, 20), (150, 12)):
        cv2.circle(image, (column, 50), radius, 255, -1)
    rendered = connected_regions(image, 12)
    ideal = _connected([region(50.5, 20), region(85.5, 20), region(150.5, 12)])
    assert len(rendered) == len(ideal) == 2
    for one, other in zip(rendered, ideal, strict=True):
        assert (other.column, other.row) == pytest.approx((one.column, 50), abs=0.6)
        assert other.area == pytest.approx(one.area, rel=0.1)
        assert other.moments == pytest.approx(one.moments, rel=0.15, abs=1)


def test_region_that_touches_two_others_joins_them() -> None:
    apart, bridge = [region(30, 10), region(70, 10)], region(50, 11)
    assert len(_connected(apart)) == 2
    assert len(_connected([*apart, bridge])) == 1


def test_regions_are_connected_alike_in_any_order() -> None:
    """Compare silhouettes, not the ellipse of connected ones, which is longer."""
    row = [region(column, 10) for column in (20, 39, 58, 80)]
    image = np.zeros((100, 200), np.uint8)
    for each in row:
        cv2.circle(image, (round(each.column), 50), 10, 255, -1)
    assert len(connected_regions(image, 12)) == 2
    for order in itertools.permutations(row):
        areas = [each.area for each in _connected(list(order))]
        assert areas == [3 * row[0].area, row[0].area]

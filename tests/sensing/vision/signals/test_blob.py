"""Blobs of ellipses, at every place in the image."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.documents.robot import Camera
from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.vision.regions.camera import heading, sight
from cbdsl.sensing.vision.signals.blob_signals import blob_of

CAMERA = Camera(link="eye", width=320, height=240, focal_length=418.5)
ANGLES = st.floats(-1.5, 1.5)


def ellipse(longer: float, shorter: float, angle: float, column: float, row: float) -> Region:
    """Return an ellipse of semi-axes, px, that rises by an angle to the left."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[-c, s], [-s, -c]])  # columns and rows of an image run against headings
    spread = turn @ np.diag([longer**2, shorter**2]) @ turn.T / 4
    moments = Moments(spread[0, 0], spread[0, 1], spread[1, 1])
    return Region(round(math.pi * longer * shorter), column, row, False, moments)


@given(angle=ANGLES, longer=st.floats(6, 30), ratio=st.floats(1.3, 6))
def test_extent_and_orientation_are_those_of_the_ellipse(
    angle: float, longer: float, ratio: float
) -> None:
    blob = blob_of(CAMERA, ellipse(longer, longer / ratio, angle, 160, 120))
    assert blob.extent * 418.5 == pytest.approx([longer, longer / ratio])
    assert blob.orientation == pytest.approx(angle, abs=1e-6)


@given(angle=ANGLES, column=st.floats(20, 300), row=st.floats(20, 220))
def test_away_from_the_middle_extents_are_angles_as_headings_are(
    angle: float, column: float, row: float
) -> None:
    region = ellipse(8, 2, angle, column, row)
    blob = blob_of(CAMERA, region)
    end = np.array([-math.cos(angle), -math.sin(angle)]) * 0.1
    step = heading(sight(CAMERA, column + end[0], row + end[1])) - heading(
        sight(CAMERA, column, row)
    )
    assert blob.extent[0] == pytest.approx(80 * np.linalg.norm(step), rel=0.03)
    turned = math.atan2(step[1], step[0]) - blob.orientation
    # An axis is the same after half a turn; a stretched ellipse leans a little to the other side.
    assert math.sin(turned) == pytest.approx(0, abs=0.03)


@given(angle=ANGLES)
def test_orientation_is_equal_after_half_a_turn(angle: float) -> None:
    one, other = (
        blob_of(CAMERA, ellipse(9, 3, a, 100, 90)).orientation for a in (angle, angle + math.pi)
    )
    assert one == pytest.approx(other)


def test_round_blob_has_no_orientation() -> None:
    assert blob_of(CAMERA, ellipse(10, 9.5, 0.3, 160, 120)).orientation is None

"""Sizes of objects from two silhouettes: ellipsoids of known axes, and objects of stages."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.pair_names import pair_resource
from cbdsl.robot.resources import SOLID_PARTS, resources
from cbdsl.runtime.episode import Runner
from cbdsl.sensing.channels import Moments, Region
from cbdsl.sensing.vision.shapes.solid import Silhouette, Solid
from tests.backends.conftest import stage_named
from tests.conftest import Checked

CAMERA = Camera(link="eye", width=320, height=240, focal_length=418.5)
LEVEL = -0.42


def looking(eye: Floats, at: Floats) -> Frame:
    """Return the frame of a camera that looks at a point (x forward, y left, z up)."""
    forward = (at - eye) / np.linalg.norm(at - eye)
    left = np.cross([0.0, 0.0, 1.0], forward)
    left /= np.linalg.norm(left)
    return Frame(eye, np.column_stack([forward, left, np.cross(forward, left)]))


def silhouette(frame: Frame, centre: Floats, axes: Floats) -> Silhouette:
    """Return the silhouette of a far ellipsoid with the matrix of its squared semi-axes."""
    x, *_ = frame.rotation.T @ (centre - frame.position)
    across = frame.rotation[:, 1:].T / x
    (u, uv), (_, v) = across @ axes @ across.T * CAMERA.focal_length**2 / 4.0
    return Silhouette(CAMERA, frame, Region(900, 160.0, 120.0, False, Moments(u, uv, v)))


def seen(along: float, across: float, height: float, yaw: float, place: Floats) -> Solid:
    """Return the size of an ellipsoid on the level, from two cameras above a robot's torso."""
    centre = np.array([*place, LEVEL + height / 2])
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    axes = np.zeros((3, 3))
    axes[:2, :2] = turn @ np.diag([along**2, across**2]) @ turn.T / 4.0
    axes[2, 2] = height**2 / 4.0
    eyes = [np.array([0.28, side, 0.56]) for side in (0.15, -0.15)]
    solid = Solid()
    solid.see(centre, LEVEL, [silhouette(looking(eye, centre), centre, axes) for eye in eyes])
    return solid


lengths = st.floats(0.03, 0.2)


@given(
    lengths, st.floats(0.3, 0.95), st.floats(0.2, 2.0), st.floats(-1.5, 1.5), st.floats(-0.3, 0.1)
)
def test_solid_of_an_ellipsoid_has_its_extents_and_height(
    along: float, narrow: float, high: float, yaw: float, y: float
) -> None:
    across = along * narrow
    solid = seen(along, across, high * across, yaw, np.array([0.6, y]))
    # The far ellipsoid of this test has no perspective, for which the height is corrected.
    assert solid.height == pytest.approx(max(high * across, 0.004), rel=0.15)
    assert solid.rise == pytest.approx(high * across / 2)
    longer, shorter = solid.extents
    assert longer == pytest.approx(along, rel=0.12)
    assert shorter == pytest.approx(across, rel=0.12)
    assert solid.bulk**3 == pytest.approx(math.pi / 6 * longer * shorter * solid.height)


@given(st.floats(-1.5, 1.5), st.floats(-0.3, 0.1))
def test_solid_of_a_long_object_turns_the_tip_along_it_and_down(yaw: float, y: float) -> None:
    place = np.array([0.6, y])
    tip = seen(0.2, 0.06, 0.05, yaw, place).facing_down(np.array([*place, 0.0]))
    assert tip.T @ tip == pytest.approx(np.eye(3)) and np.linalg.det(tip) == pytest.approx(1.0)
    assert tip[:, 2] == pytest.approx([0.0, 0.0, -1.0])
    assert abs(tip[:2, 0] @ [math.cos(yaw), math.sin(yaw)]) > math.cos(math.radians(3))
    assert tip[:2, 0] @ place > 0.0


def test_solid_of_a_round_object_turns_the_tip_away_from_the_robot() -> None:
    place = np.array([0.6, -0.2])
    tip = seen(0.08, 0.08, 0.1, 0.0, place).facing_down(np.array([*place, 0.0]))
    assert tip[:2, 0] == pytest.approx(place / np.linalg.norm(place))


@given(st.floats(-1.5, 1.5), st.floats(-0.4, 0.2), st.floats(-0.3, 0.3))
def test_solid_of_an_edged_object_turns_a_level_tip_along_its_nearest_axis(
    yaw: float, y: float, side: float
) -> None:
    place, start = np.array([0.6, y]), np.array([0.0, side, 0.2])
    tip = seen(0.12, 0.06, 0.2, yaw, place).facing_aside(np.array([*place, 0.0]), start)
    assert tip.T @ tip == pytest.approx(np.eye(3)) and np.linalg.det(tip) == pytest.approx(1.0)
    assert tip[:, 0] == pytest.approx([0.0, 0.0, 1.0])
    along = abs(tip[:2, 2] @ [math.cos(yaw), math.sin(yaw)])
    assert max(along, math.sqrt(1.0 - min(along, 1.0) ** 2)) > math.cos(math.radians(3))
    away = place - start[:2]
    assert tip[:2, 2] @ away / np.linalg.norm(away) > math.cos(math.radians(49))


def test_solid_of_a_round_object_turns_a_level_tip_away_from_its_start() -> None:
    place, start = np.array([0.6, -0.2]), np.array([0.1, -0.15, 0.3])
    tip = seen(0.08, 0.08, 0.2, 0.0, place).facing_aside(np.array([*place, 0.0]), start)
    assert tip[:2, 2] == pytest.approx((place - start[:2]) / np.linalg.norm(place - start[:2]))


def test_solid_without_measurement_is_unknown() -> None:
    solid = seen(0.1, 0.1, 0.1, 0.0, np.array([0.6, 0.0]))
    assert solid.is_known
    solid.reset()
    assert not solid.is_known


@pytest.mark.parametrize(
    ("context", "length", "width", "height"),
    [
        ("soup_can", 6.6, 6.6, 10),
        ("book", 20, 14, 3),
        ("softball", 12, 12, 12),
        ("die", 2.5, 2.5, 2.5),
    ],
)
def test_size_of_an_everyday_object_is_that_of_the_stage(
    context: str, length: float, width: float, height: float,
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, checked: Checked,
) -> None:  # fmt: skip
    """Extents of boxes and upright cylinders are larger: those of ellipsoids of equal moments."""
    backend, known = embody("kinematic", dexter, urdf), resources(dexter)
    named = {p: pair_resource(f"stereo.red.on.green.{p}", known) for p in SOLID_PARTS}
    observed = [each for each in named.values() if each]
    runner = Runner(dexter, kinematics, checked("survey"), backend, observed=observed)
    runner.run(stage_named("everyday_objects"), 61_000, context)
    read = {part: runner.signals.read(each) for part, each in named.items() if each}
    backend.close()
    found = {part: reading.value for part, reading in read.items() if reading is not None}
    assert found.keys() == SOLID_PARTS.keys()
    assert 0.9 * length < 100 * found["length"][0] < 1.6 * length
    assert 0.9 * width < 100 * found["width"][0] < 1.5 * width
    assert 100 * found["height"][0] == pytest.approx(height, abs=2.5)
    assert 100 * (found["top"][2] - LEVEL) == pytest.approx(height, abs=4.5)

"""Load cells measure the wrenches that fingertips exert on the world."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.robot.joints import Joints
from tests.backends.conftest import contact_loads, made_stage


def _forces(backend: BulletBackend) -> np.ndarray:
    loads = contact_loads(backend)
    return np.array([loads["right_hand", f"finger_{k}"][:3] for k in (1, 2, 3)])


def _flex(backend: BulletBackend, force: float, seconds: float) -> None:
    """Flex the right fingers until they press with about ``force``, N; the thumb twice."""
    fingers = Joints(backend._robot).pick([f"right_finger_{k}" for k in (1, 2, 3)])
    goal = force * np.array([0.53, 0.53, 1.0])
    reference = backend.observe().positions
    for _ in range(round(seconds / backend.control_period)):
        pressed = np.linalg.norm(_forces(backend), axis=1)
        speed = np.where(pressed > 0.1, np.clip(0.4 * (goal - pressed), -0.3, 0.3), 0.3)
        angles = backend.observe().positions[fingers]
        reference[fingers] += speed * backend.control_period
        reference[fingers] = np.clip(reference[fingers], angles - 0.15, angles + 0.15)
        backend.apply(reference)
        backend.step()


def test_load_cells_of_fingers_pressing_on_a_plate_point_into_it(blind: BulletBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    palm = blind.truth.link_pose("right_palm").position
    plate = {
        "form": {"shape": "box", "size": [0.5, 0.5, 0.02]},
        "position": [palm[0], palm[1], palm[2] - 0.09],
    }
    blind.reset(made_stage({}, fixtures={"plate": plate}), None, np.random.default_rng(0))
    _flex(blind, force=2.0, seconds=3.0)
    touches = blind.truth.touches("plate")
    assert {touch.cell[1] for touch in touches} == {"finger_1", "finger_2", "finger_3"}
    for finger, force in zip(("finger_1", "finger_2", "finger_3"), _forces(blind), strict=True):
        own = [np.array(touch.force) for touch in touches if touch.cell[1] == finger]
        assert force == pytest.approx(sum(own), abs=0.1), "the filter has settled"
        assert force[2] < -0.5, "the palm faces down, so fingertips push down"
        torque = contact_loads(blind)["right_hand", finger][3:]
        assert 0 < np.linalg.norm(torque) < 0.015 * np.linalg.norm(force)


def test_load_cells_of_fingers_carrying_a_ball_sum_to_its_weight(blind: BulletBackend) -> None:
    """Friction carries it, so this fails for a wrong sign of either friction term."""
    ball = {"form": {"shape": "ball", "radius": 0.06}, "mass": 0.25}
    place = {"hand": "right_arm", "gap": 0.01, "held": True}
    context = {"things": ["ball"], "place": place, "released_after": 2.5}
    stage = made_stage(context, things={"ball": ball})
    blind.reset(stage, None, np.random.default_rng(0))
    start = blind.truth.pose("ball").position
    _flex(blind, force=5.0, seconds=5.0)
    assert np.linalg.norm(blind.truth.pose("ball").position - start) < 0.04, "it is carried"
    assert _forces(blind).sum(axis=0) == pytest.approx([0, 0, 0.25 * 9.81], abs=0.05)
    for finger, force in zip(("finger_1", "finger_2", "finger_3"), _forces(blind), strict=True):
        cell = blind._robot.load_cells["right_hand"][finger]
        normal = blind.truth.link_pose(cell.link).rotation @ cell.normal
        assert force @ normal > 1, "it presses along the robot file's normal"

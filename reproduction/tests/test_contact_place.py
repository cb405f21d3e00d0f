"""Where a round fingertip is touched, by force and torque."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl_reproduction.chapter_5.contact_place import contact_places, on_ball

RADIUS = 0.012


@pytest.mark.parametrize("seed", range(5))
def test_place_of_a_contact_with_friction_is_recovered(seed: int) -> None:
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    place = RADIUS * normal
    # Within the cone of friction, so that the force alone would point elsewhere.
    force = 2.0 * normal + 0.5 * np.cross(normal, rng.normal(size=3))
    load = np.concatenate([force, np.cross(place, force)])
    assert on_ball(load, RADIUS) == pytest.approx(place, abs=1e-9)
    assert np.linalg.norm(RADIUS * force / np.linalg.norm(force) - place) > 1e-4


def test_torque_that_no_contact_causes_keeps_the_place_on_the_ball() -> None:
    load = np.array([0.0, 0.0, -1.0, 0.1, 0.0, 0.0])
    assert np.linalg.norm(on_ball(load, RADIUS)) == pytest.approx(RADIUS)


def test_each_loaded_finger_has_a_contact_place(
    dexter: RobotDocument, kinematics: Kinematics, posture: np.ndarray
) -> None:
    signals = Signals(dexter, kinematics, ())
    loads = {(hand, each): np.zeros(6) for hand, own in dexter.load_cells.items() for each in own}

    def feel() -> None:
        still = np.zeros_like(posture)
        copies = {cell: load.copy() for cell, load in loads.items()}
        signals.update(Observation(0.0, posture, still, copies, {}))

    feel()
    assert contact_places(signals, "right_hand", RADIUS).shape == (0, 3)
    down, across = np.array([0.0, 0.0, -3.0]), np.array([0.0, 2.0, 0.0])
    loads["right_hand", "finger_1"][:3] = down
    loads["right_hand", "finger_3"][:3] = across
    loads["left_hand", "finger_2"][:3] = down
    feel()
    cells = dexter.load_cells["right_hand"]
    wanted = [
        kinematics.frame(cells[finger].link).position + RADIUS * force / np.linalg.norm(force)
        for finger, force in (("finger_1", down), ("finger_3", across))
    ]
    places = contact_places(signals, "right_hand", RADIUS)
    np.testing.assert_allclose(places, wanted, atol=1e-12)

"""Late images are interpreted at the time when they were taken."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import Regions, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.memory.memory import PositionMemory
from tests.backends.conftest import URDF, exact, made_stage, with_vision

BALL = {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.25, "color": [1, 0, 0]}
SHOWN = {"things": ["ball"], "place": {"x": 0.6, "z": -0.2, "held": True}}
AHEAD = {"pan": 0.0, "tilt": 1.0}
FEATURE = "hue_1"
PERIOD = 0.05


def swings(backend: KinematicBackend, pan: int) -> Iterator[Observation]:
    """Yield observations while the head turns past an object, at 0.6 rad/s."""
    stage = made_stage({**SHOWN, "joints": AHEAD}, things={"ball": BALL})
    backend.reset(stage, None, np.random.default_rng(0))
    x, y, _ = place_of_thing(backend)
    reference = backend.observe().positions.copy()
    for tick in range(40):
        reference[pan] = math.atan2(y, x) + 0.6 * PERIOD * (max(tick, 20) - 25)
        backend.apply(reference)
        backend.step()
        if tick >= 20:
            yield backend.observe()


def place_of_thing(backend: KinematicBackend) -> np.ndarray:
    return backend.truth.pose("ball").position


@pytest.mark.parametrize("latency", [0.0, 0.1])
def test_head_that_turns_sees_a_thing_stand_still(
    dexter: RobotDocument, kinematics: Kinematics, latency: float
) -> None:
    """Late images taken for new would cause an error of 4 cm at 70 cm."""
    robot = with_vision(exact(dexter), latency=latency)
    backend = KinematicBackend(robot, URDF)
    feature = resources(robot)[f"stereo.{FEATURE}"]
    signals, places = Signals(robot, kinematics, (feature,)), []
    for observation in swings(backend, Signals(robot, kinematics, ()).joints.index["pan"]):
        signals.update(observation)
        if (seen := signals.read(feature)) is not None:
            places.append(seen.value)
    truth = place_of_thing(backend)
    backend.close()
    assert len(places) >= 8
    assert max(np.linalg.norm(place - truth) for place in places) < 0.012


def test_heading_is_that_of_now(dexter: RobotDocument, kinematics: Kinematics) -> None:
    """Head and heading have turned by 0.06 rad since the image was taken.

    The camera is not on the axis: how far it has moved aside shows by the thing's distance alone.
    """
    headings: dict[float, dict[float, np.ndarray]] = {}
    for latency in (0.0, 0.1):
        robot = with_vision(exact(dexter), latency=latency)
        backend = KinematicBackend(robot, URDF)
        feature = resources(robot)[f"left.{FEATURE}"]
        signals, own = Signals(robot, kinematics, (feature,)), headings.setdefault(latency, {})
        pan = signals.joints.index["pan"]
        for observation in swings(backend, pan):
            signals.update(observation)
            if observation.regions and (seen := signals.read(feature)) is not None:
                own[round(float(observation.positions[pan]), 6)] = seen.value
        backend.close()
    both = headings[0.0].keys() & headings[0.1].keys()
    assert len(both) >= 4
    for angle in both:
        assert headings[0.1][angle] == pytest.approx(headings[0.0][angle], abs=0.02)


def test_displacement_since_the_image_is_added_to_the_seen_place() -> None:
    memory = PositionMemory(Regions())
    sizes, place, along = (1e-2, 1e-2), np.array([0.5, 0.0, 0.3]), np.array([0.01, 0.0, 0.0])
    memory.see(0.0, place, sizes)
    for tick in range(1, 9):
        memory.carry(along)
        memory.predict(PERIOD, tick * PERIOD)
    # An image of the sixth tick that comes at the eighth.
    shown = place + 6 * along
    assert memory.moved_since(6 * PERIOD) == pytest.approx(2 * along)
    memory.see(8 * PERIOD, shown + memory.moved_since(6 * PERIOD), sizes)
    assert memory.position == pytest.approx(place + 8 * along)


def test_moving_object_is_extrapolated_to_the_present() -> None:
    memory = PositionMemory(Regions())
    sizes, speed, latency = (1e-2, 1e-2), np.array([0.2, 0.0, 0.0]), 2
    for tick in range(40):
        memory.predict(PERIOD, tick * PERIOD)
        exposed = max(tick - latency, 0) * PERIOD
        shown = speed * exposed
        memory.see(tick * PERIOD, shown + memory.moved_since(exposed), sizes)
    assert memory.position == pytest.approx(speed * 39 * PERIOD, abs=1e-3)

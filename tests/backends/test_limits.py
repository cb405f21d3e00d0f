"""Every backend that can be used keeps the URDF's limits of velocity and effort."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.backend import Backend, embody
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfJoint
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import Library
from tests.backends.conftest import SELF_CONTAINED, robot_named, sightless
from tests.conftest import ROOT

NAMES = sorted(SELF_CONTAINED)
ROBOTS = Library(ROOT).names(RobotDocument)
EMPTY = {"cbdsl": 1, "kind": "stage", "name": "empty", "contexts": {"only": {}}}
# Fingers that push one another exceed the speed of their servos by 6 percent: the error that the
# solver leaves after its 20 iterations. Torques are rounded.
FASTER, STRONGER = 1.1, 1.0 + 1e-6


def _limits(robot: RobotDocument) -> list[UrdfJoint]:
    joints = read_urdf(ROOT / "robots" / robot.model).joints
    return [joints[name] for name in Joints(robot).names]


def _driven(backend: Backend, limits: list[UrdfJoint]) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the largest speeds and torques while references jump up to and past the limits."""
    ends = np.array([(joint.upper + 1, joint.lower - 1) for joint in limits]).T
    speeds, torques = np.zeros(len(limits)), None
    for reference in (*ends, *ends):
        backend.apply(reference)
        for _ in range(round(0.6 / backend.control_period)):
            backend.step()
            simulated = isinstance(backend, SimulatedBackend)
            now = backend.truth.read()[1] if simulated else backend.observe().velocities
            speeds = np.maximum(speeds, np.abs(now))
            # A kinematic engine has no forces, only speed limits.
            if (
                isinstance(backend, SimulatedBackend)
                and (own := backend.truth.efforts()) is not None
            ):
                torques = np.maximum(np.abs(own), 0.0 if torques is None else torques)
    return speeds, torques


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("name", NAMES)
def test_velocity_and_effort_stay_below_the_limits(name: str, robot: str) -> None:
    document = sightless(robot_named(robot))
    backend = embody(name, document, ROOT / "robots" / document.model)
    stage = StageDocument.model_validate({**EMPTY, "robot": robot})
    backend.reset(stage, None, np.random.default_rng(0))
    limits = _limits(document)
    speeds, torques = _driven(backend, limits)
    backend.close()
    largest = np.array([joint.velocity for joint in limits])
    assert (speeds <= FASTER * largest).all(), (speeds / largest).round(3)
    assert (speeds > 0.5 * largest).any(), "they are driven to their limits"
    if torques is not None:
        assert (torques <= STRONGER * np.array([joint.effort for joint in limits])).all()
        assert torques.any()


@pytest.mark.parametrize("torque", [1.0, 1e4])
def test_smaller_of_two_efforts_counts(torque: float) -> None:
    robot = sightless(robot_named("sixaxis"))
    names = Joints(robot).names
    simulation = robot.simulation.model_copy(update={"efforts": dict.fromkeys(names, torque)})
    robot = robot.model_copy(update={"simulation": simulation})
    backend = embody("bullet", robot, ROOT / "robots" / robot.model)
    backend.reset(
        StageDocument.model_validate({**EMPTY, "robot": "sixaxis"}), None, np.random.default_rng(0)
    )
    limits = _limits(robot)
    _, torques = _driven(backend, limits)
    backend.close()
    assert torques is not None
    assert (torques <= STRONGER * np.array([min(torque, joint.effort) for joint in limits])).all()

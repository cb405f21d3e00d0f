"""A backend without physics: ideal servos, ideal cameras, and contacts by geometry."""

from __future__ import annotations

from pathlib import Path

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras.selection import make_cameras
from cbdsl.backends.kinematic.engine import KinematicEngine
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.backends.staging.fit import read_fitting
from cbdsl.documents.robot import RobotDocument

# Ticks of the robot's own control cycle in one of ours. With more, an arm that is stretched out
# to something beyond its reach swings from tick to tick.
_SPARSER = 3


class KinematicBackend(SimulatedBackend[KinematicEngine]):
    """A robot that is moved, without forces, in a world that gives way.

    Joints are where their references are, as far as the URDF's limits of position and velocity
    allow; there are no forces that its limits of effort could bound. Cameras see regions of colour
    where things are, as far as nothing hides them. Fingertips are springs along the surfaces that
    they are pressed into; those that go too deep are held back. What is grasped goes where the
    hands go, and what nobody holds falls onto fixtures, rolls and slides, but never topples. There
    are fewer ticks than the robot's control rate asks for.

    Args:
        robot: what can be sensed and moved.
        urdf: its model.
        gui: must be false, since there is no window.
        cameras: ``rendered`` or ``ideal``; ideal without a choice.

    Raises:
        BackendError: robot file and model do not fit together, a window is asked for, or nothing
            can render here.
    """

    def __init__(
        self, robot: RobotDocument, urdf: Path, *, gui: bool = False, cameras: str | None = None
    ) -> None:
        if gui:
            raise BackendError("the kinematic backend has no window")
        model, rate = read_fitting(robot, urdf), rate_of(robot)
        eyes = make_cameras(cameras or "ideal", robot, model)
        super().__init__(robot, model, KinematicEngine(robot, model, 1 / rate), eyes, rate)


def rate_of(robot: RobotDocument) -> float:
    """Control rate of the robot here, Hz.

    What has no inertia needs no fast control, and an episode costs what its ticks cost.
    """
    return min(robot.control.rate, max(robot.control.rate / _SPARSER, robot.vision.rate))

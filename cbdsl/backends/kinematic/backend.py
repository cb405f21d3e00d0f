"""Backend without physics: ideal servos, ideal cameras, and contacts by geometry."""

from __future__ import annotations

from pathlib import Path

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras.selection import make_cameras
from cbdsl.backends.kinematic.engine import KinematicEngine
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.backends.staging.fit import read_fitting
from cbdsl.documents.robot import RobotDocument

# Ticks of the robot's own control cycle in one tick of this backend. With more, an arm that is
# stretched out to an object beyond its reach swings from tick to tick.
_SPARSER = 3


class KinematicBackend(SimulatedBackend[KinematicEngine]):
    """Kinematic robot in a world that yields without forces.

    Joints follow their references within the URDF's limits of position and velocity; without
    forces, limits of effort have no effect. Cameras see regions of colour unless they are occluded.
    Fingertips are springs along the surfaces that they are pressed into; fingertips that go too
    deep are held back. Grasped objects move with the hands. Objects that are not held fall onto
    fixtures, roll and slide, but never topple. There are fewer ticks than the robot's control rate
    asks for.

    Args:
        robot: Robot document.
        urdf: URDF of the robot.
        gui: False, since there is no window.
        cameras: ``rendered`` or ``ideal``; ideal if ``None``.

    Raises:
        BackendError: Robot file and model do not fit together, a window is requested, or rendering
            does not work here.
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
    """Return the control rate of the robot on this backend, Hz.

    Without inertia no fast control is needed, and each tick adds to an episode's run time.
    """
    return min(robot.control.rate, max(robot.control.rate / _SPARSER, robot.vision.rate))

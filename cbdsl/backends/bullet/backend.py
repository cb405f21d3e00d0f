"""The reference backend: PyBullet's physics, rendered stereo images and fingertip load cells."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.engine import BulletEngine
from cbdsl.backends.bullet.tiny import TinyRenderer
from cbdsl.backends.cameras.selection import make_cameras
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.backends.staging.fit import physics_steps, read_fitting, require_meshes
from cbdsl.documents.robot import RobotDocument


class BulletBackend(SimulatedBackend[BulletEngine]):
    """A robot in PyBullet, with contacts and forces.

    Args:
        robot: Robot document.
        urdf: URDF of the robot.
        gui: True to open the simulator's window.
        cameras: ``rendered`` or ``ideal``; rendered if ``None``.

    Raises:
        BackendError: Robot file and model do not fit together, the requested renderer does not work
            here, or there is no screen for a window.
    """

    def __init__(
        self, robot: RobotDocument, urdf: Path, *, gui: bool = False, cameras: str | None = None
    ) -> None:
        if gui and sys.platform == "linux" and not os.environ.get("DISPLAY"):
            # The simulator would end the process.
            raise BackendError("the simulator's window needs a screen, but DISPLAY is not set")
        model, substeps = read_fitting(robot, urdf), physics_steps(robot)
        require_meshes(model, model.meshes)
        engine = BulletEngine(robot, model, 1 / robot.control.rate / substeps, gui=gui)
        try:
            own = {"tiny": lambda: TinyRenderer(engine.client)}
            eyes = make_cameras(cameras, robot, model, own)
        except BackendError:
            engine.close()
            raise
        super().__init__(robot, model, engine, eyes, robot.control.rate, substeps)

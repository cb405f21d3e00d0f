"""Faster backend with physics: MuJoCo's steady contacts, rendered or ideal cameras."""

from __future__ import annotations

from pathlib import Path

from cbdsl.extend.backend import (
    RobotDocument,
    SimulatedBackend,
    make_cameras,
    physics_steps,
    read_fitting,
    require_meshes,
)
from cbdsl_mujoco.engine import MujocoEngine
from cbdsl_mujoco.own_renderer import MujocoRenderer
from cbdsl_mujoco.window import Window


class MujocoBackend(SimulatedBackend[MujocoEngine]):
    """A robot in MuJoCo, with contacts and forces.

    Args:
        robot: Robot document.
        urdf: URDF of the robot.
        gui: True to open the simulator's window.
        cameras: ``rendered`` or ``ideal``; if ``None``, rendered, or ideal without OpenGL.

    Raises:
        BackendError: Robot file and model do not fit together, the requested renderer does not work
            here, or there is no screen for a window.
    """

    def __init__(
        self, robot: RobotDocument, urdf: Path, *, gui: bool = False, cameras: str | None = None
    ) -> None:
        window = Window() if gui else None
        model, substeps = read_fitting(robot, urdf), physics_steps(robot)
        bodies = model.bodies.values()
        require_meshes(model, {shape.file for body in bodies for shape in body.collisions})
        own = {"mujoco": lambda: MujocoRenderer(robot, model)}
        eyes = make_cameras(cameras, robot, model, own)
        engine = MujocoEngine(robot, model, 1 / robot.control.rate / substeps, window)
        super().__init__(robot, model, engine, eyes, robot.control.rate, substeps)

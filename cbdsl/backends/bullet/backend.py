"""The reference backend: PyBullet's physics, rendered stereo images and fingertip load cells."""

from __future__ import annotations

import os
import sys
from collections.abc import Collection
from pathlib import Path

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.body import Body
from cbdsl.backends.bullet.cameras import Cameras
from cbdsl.backends.bullet.experimenter import Experimenter
from cbdsl.backends.bullet.load_cells import LoadCells
from cbdsl.backends.bullet.renderer import NoRenderer, Renderer, make_renderer
from cbdsl.backends.bullet.scene import Scene
from cbdsl.backends.bullet.touch import Fingertips
from cbdsl.backends.bullet.truth import Truth
from cbdsl.backends.staging.context import choose_context, starting_posture
from cbdsl.backends.staging.presentation import GRAVITY, Presenter
from cbdsl.backends.staging.shutter import Shutter
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.joints import Joints
from cbdsl.sensing.observation import Observation

Floats = NDArray[np.float64]


class BulletBackend:
    """A robot in PyBullet.

    Every episode starts from an empty world, so that nothing of the one before, not even a cached
    contact, can reach into it.

    Args:
        robot: what can be sensed and moved.
        urdf: its model.
        gui: whether to open the simulator's window.

    Attributes:
        renderer: what makes the images, for people.
        control_period: simulated time of one step, s.

    Raises:
        BackendError: robot file and model do not fit together, the renderer that the robot file
            asks for does not work here, or there is no screen for a window.
    """

    def __init__(self, robot: RobotDocument, urdf: Path, gui: bool = False) -> None:
        if gui and sys.platform == "linux" and not os.environ.get("DISPLAY"):
            # The simulator would end the process.
            raise BackendError("the simulator's window needs a screen, but DISPLAY is not set")
        self._robot = robot
        self._urdf = urdf
        self._joints = Joints(robot)
        self._substeps = _substeps(robot)
        self.control_period = 1 / robot.control.rate
        self._shutter = Shutter(robot.vision.rate, self.control_period)
        self._client: int = p.connect(p.GUI if gui else p.DIRECT)
        try:
            self._empty_world()
            for camera in robot.cameras.values():
                self._body.link(camera.link)
            self._renderer = self._make_renderer()
        except BackendError:
            p.disconnect(physicsClientId=self._client)
            raise
        self.renderer = self._renderer.name

    def _make_renderer(self) -> Renderer:
        if not self._robot.cameras:
            return NoRenderer()
        return make_renderer(self._client, self._robot.vision.renderer, [self._body.id])

    def _empty_world(self) -> None:
        """A world with nothing but the robot in it."""
        simulation = self._robot.simulation
        p.resetSimulation(physicsClientId=self._client)
        p.setGravity(0, 0, -GRAVITY, physicsClientId=self._client)
        p.setPhysicsEngineParameter(
            fixedTimeStep=self.control_period / self._substeps,
            numSolverIterations=simulation.solver_iterations,
            numSubSteps=0,
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )
        self._body = Body(self._client, self._robot, self._joints, self._urdf)
        self._fingertips = Fingertips(self._client, self._robot, self._body)
        self._scene = Scene(self._client)
        #: What only the simulator knows, for tests.
        self.truth = Truth(self._client, self._body, self._scene, self._fingertips)

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; see ``Backend.reset``."""
        name = choose_context(stage, context, rng)
        chosen = stage.contexts[name]
        # The sensors' noise has a stream of its own: who else draws from rng cannot change it.
        noise = np.random.default_rng(rng.integers(2**63))
        self._empty_world()
        self._tick = 0
        self._reference = starting_posture(
            chosen, self._robot, self._joints, self._body.nearest_to_zero(), rng
        )
        self._reached = self._reference
        self._body.place(self._reference)
        self._cells = LoadCells(
            self._fingertips, self._robot.contact, self.control_period / self._substeps, noise
        )
        presentation = Presenter(stage, self._robot, self.truth.link_pose, rng).present(chosen)
        self._experimenter = Experimenter(self._client, presentation, self._scene, self.truth)
        self.cameras = Cameras(
            self._robot, self._body, self._renderer, stage.disturbance, rng, noise
        )
        self._show()
        self._observation = self._sense()
        return name

    def _show(self) -> None:
        self._renderer.show([self._body.id, *self._scene.bodies.values()])

    def observe(self) -> Observation:
        """The sensors now."""
        return self._observation

    def _sense(self) -> Observation:
        positions, velocities = self._body.read()
        return Observation(
            time=self._tick * self.control_period,
            positions=positions,
            velocities=velocities,
            loads=self._cells.read(),
            images=self.cameras.take() if self._shutter.opens(self._tick) else {},
        )

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,), for the end of the step."""
        self._reference = np.array(reference, dtype=np.float64)

    def step(self) -> None:
        """Let one control period pass.

        Joint references move evenly over its physics steps: a jump per control period would shake
        what is held out of the hand.
        """
        change = self._reference - self._reached
        for substep in range(1, self._substeps + 1):
            begun = self._tick + (substep - 1) / self._substeps
            if self._experimenter.act(begun * self.control_period):
                self._show()
            self._body.drive(self._reached + change * (substep / self._substeps))
            p.stepSimulation(physicsClientId=self._client)
            self._cells.sample()
        self._reached = self._reference
        self._tick += 1
        self._observation = self._sense()

    def close(self) -> None:
        """Leave the simulator and free the renderer."""
        self._renderer.close()
        p.disconnect(physicsClientId=self._client)


def _substeps(robot: RobotDocument) -> int:
    """Physics steps per control period.

    Raises:
        BackendError: there is no whole number of them.
    """
    ratio = robot.simulation.physics_rate / robot.control.rate
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9:
        raise BackendError(
            f"robot '{robot.name}': the physics rate, {robot.simulation.physics_rate:g} Hz, "
            f"must be a multiple of the control rate, {robot.control.rate:g} Hz"
        )
    return round(ratio)

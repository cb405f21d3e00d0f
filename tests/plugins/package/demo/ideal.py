"""Robot whose joints follow their references at full speed, without objects or images."""

from collections.abc import Collection
from pathlib import Path

import numpy as np

from cbdsl.extend.backend import (
    BackendError,
    Floats,
    Kinematics,
    Observation,
    RobotDocument,
    StageDocument,
    read_urdf,
)


class IdealBackend:
    """Joints without errors; see ``cbdsl.extend.backend.Backend``."""

    renderer = "nothing"
    deadline = None

    def __init__(self, robot: RobotDocument, urdf: Path, gui: bool = False) -> None:
        if gui:
            raise BackendError("the ideal backend has no window")
        self._robot = robot
        self._joints = Kinematics(robot, urdf).joints
        self.control_period = 1 / robot.control.rate
        model = read_urdf(urdf)
        self._positions = self._reference = np.zeros(len(self._joints.names))
        speeds = [model.joints[name].velocity for name in self._joints.names]
        self._farthest = self.control_period * np.array(speeds)
        # A load cell that touches nothing bears the weight of its tip, N.
        self._loads = {
            (hand, finger): np.array([0, 0, 9.81 * body.mass if body else 0, 0, 0, 0])
            for hand, cells in robot.load_cells.items()
            for finger, cell in cells.items()
            for body in [model.bodies[cell.link].inertial]
        }

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        self._time = 0.0
        self._positions = np.zeros(len(self._joints.names))
        for name, effector in self._robot.effectors.items():
            if effector.start is not None:
                self._positions[self._joints.of(name)] = effector.postures[effector.start]
        self._reference = self._positions
        self._velocities = np.zeros_like(self._positions)
        return context or next(iter(stage.contexts))

    def observe(self) -> Observation:
        return Observation(self._time, self._positions, self._velocities, self._loads, {})

    def apply(self, reference: Floats) -> None:
        self._reference = np.array(reference)

    def step(self) -> None:
        way = np.clip(self._reference - self._positions, -self._farthest, self._farthest)
        self._velocities = way / self.control_period
        self._positions = self._positions + way
        self._time += self.control_period

    def halt(self) -> None:
        self._reference = self._positions

    def close(self) -> None:
        """Release nothing, because nothing was opened."""

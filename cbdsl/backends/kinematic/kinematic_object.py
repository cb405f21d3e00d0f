"""An object of the stage, as the kinematic engine moves it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.solids import POSITION, ROTATION, placed

Floats = NDArray[np.float64]


class KinematicObject:
    """A fixture, or a thing that can be moved.

    Attributes:
        name: as the stage has it.
        shape: of definite size.
        surface: its colour and friction.
        mass: kg; 0 for a fixture.
        solid: as ``solids`` has it, shape (16,); its pose.
        velocity: of its centre, m/s, shape (3,).
        rolling: velocity at which it would roll without sliding, as it spins, m/s, shape (3,).
        gripped: whether the experimenter holds it.
        resting: whether it stands still on something, and will until somebody moves it.
    """

    def __init__(self, item: SceneObject) -> None:
        self.name, self.shape, self.surface, self.mass, pose = item
        self.solid = placed(self.shape, pose)
        self.velocity: Floats = np.zeros(3)
        self.rolling: Floats = np.zeros(3)
        self.gripped = self.resting = False

    @property
    def position(self) -> Floats:
        """Position of its centre, m, shape (3,)."""
        return self.solid[POSITION]

    @property
    def pose(self) -> Pose:
        """Its pose now."""
        return Pose(self.solid[POSITION].copy(), self.solid[ROTATION].reshape(3, 3).copy())

    def put(self, pose: Pose) -> None:
        """Put it there."""
        self.solid[POSITION], self.solid[ROTATION] = pose.position, pose.rotation.ravel()
        self.resting = False

    def shift(self, displacement: Floats) -> None:
        """Move it, m, shape (3,)."""
        self.solid[POSITION] += displacement
        self.resting = False

    def launch(self, velocity: Floats) -> None:
        """Give it a velocity, m/s, shape (3,)."""
        self.velocity[:] = velocity
        self.resting = False

    @property
    def bottom(self) -> float:
        """Height of its lowest point, m."""
        return float(self.solid[6]) - self.shape.depth(self.solid[ROTATION].reshape(3, 3))

    @property
    def top(self) -> float:
        """Height of its highest point, m."""
        return float(self.solid[6]) + self.shape.depth(self.solid[ROTATION].reshape(3, 3))

    @property
    def rolls(self) -> bool:
        """Whether it can roll over a level floor."""
        return self.shape.kind == "ball"

    def sliding_friction(self, floor: KinematicObject) -> float:
        """Deceleration while it slides over a level floor, m/s^2."""
        return self.surface.friction * floor.surface.friction * GRAVITY

    def resistance(self, floor: KinematicObject) -> float:
        """Deceleration while it rolls, or slides if it cannot roll, on a level floor, m/s^2."""
        if not self.rolls:
            return self.sliding_friction(floor)
        # A rolling ball has two fifths more inertia than its mass.
        return 5 / 7 * self.surface.rolling_friction / self.shape.halves[0] * GRAVITY

"""Object of the stage in the kinematic engine."""

from __future__ import annotations

import numpy as np

from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.solids import POSITION, ROTATION, solid_row
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats


class KinematicObject:
    """Fixture or movable object.

    Attributes:
        name: Name in the stage.
        shape: Shape of definite size.
        surface: Colour and friction.
        mass: Mass, kg; 0 for a fixture.
        solid: Row with its pose, as in ``solids``, shape (16,).
        velocity: Velocity of its centre, m/s, shape (3,).
        rolling: Velocity at which its spin lets it roll without sliding, m/s, shape (3,).
        gripped: True if the experimenter holds it.
        resting: True if it stands still on a support, and will until it is moved.
    """

    def __init__(self, item: SceneObject) -> None:
        self.name, self.shape, self.surface, self.mass, pose = item
        self.solid = solid_row(self.shape, pose)
        self.velocity: Floats = np.zeros(3)
        self.rolling: Floats = np.zeros(3)
        self.gripped = self.resting = False

    @property
    def position(self) -> Floats:
        """Position of the object's centre, m, shape (3,)."""
        return self.solid[POSITION]

    @property
    def pose(self) -> Pose:
        """Current pose of the object."""
        return Pose(self.solid[POSITION].copy(), self.solid[ROTATION].reshape(3, 3).copy())

    def put(self, pose: Pose) -> None:
        """Set the pose."""
        self.solid[POSITION], self.solid[ROTATION] = pose.position, pose.rotation.ravel()
        self.resting = False

    def shift(self, displacement: Floats) -> None:
        """Move the object by a displacement, m, shape (3,)."""
        self.solid[POSITION] += displacement
        self.resting = False

    def launch(self, velocity: Floats) -> None:
        """Set the velocity, m/s, shape (3,)."""
        self.velocity[:] = velocity
        self.resting = False

    @property
    def bottom(self) -> float:
        """Height of the object's lowest point, m."""
        return float(self.solid[6]) - self.shape.depth(self.solid[ROTATION].reshape(3, 3))

    @property
    def top(self) -> float:
        """Height of the object's highest point, m."""
        return float(self.solid[6]) + self.shape.depth(self.solid[ROTATION].reshape(3, 3))

    @property
    def rolls(self) -> bool:
        """True if the object can roll over a level floor."""
        return self.shape.kind == "ball"

    def sliding_friction(self, floor: KinematicObject) -> float:
        """Return the deceleration while it slides over a level floor, m/s^2."""
        return self.surface.friction * floor.surface.friction * GRAVITY

    def resistance(self, floor: KinematicObject) -> float:
        """Return the deceleration on a level floor, m/s^2: rolling, or else sliding."""
        if not self.rolls:
            return self.sliding_friction(floor)
        # The effective inertia of a rolling ball is 7/5 of its mass.
        return 5 / 7 * self.surface.rolling_friction / self.shape.halves[0] * GRAVITY

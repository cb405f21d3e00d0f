"""Truth of a simulated world, for judges and tests."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from cbdsl.backends.staging.engine import Engine


class Truth:
    """State of a simulated world that only its engine knows.

    It changes with the world. The robot senses none of it: programs, policies and learners get
    observations alone. All positions are in the world frame.

    Args:
        engine: Engine of the world.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that are in the world."""
        return self._engine.names()

    def position(self, name: str) -> NDArray[np.float64]:
        """Return the position of an object's centre, m, shape (3,)."""
        # The kinematic engine returns the pose itself, and not a copy of it.
        return self._engine.pose(self._known(name)).position.copy()

    def rotation(self, name: str) -> NDArray[np.float64]:
        """Return the axes of an object as columns, shape (3, 3)."""
        return self._engine.pose(self._known(name)).rotation.copy()

    def velocity(self, name: str) -> NDArray[np.float64]:
        """Return the velocity of an object's centre while it is not held, m/s, shape (3,)."""
        return self._engine.velocity(self._known(name)).copy()

    def half_extents(self, name: str) -> NDArray[np.float64]:
        """Return half the size of an object along its own axes, m, shape (3,)."""
        import numpy as np

        return np.array(self._engine.objects[self._known(name)].shape.halves, dtype=float)

    def is_touched(self, name: str) -> bool:
        """Return whether any part of the robot touches an object."""
        return self._engine.touched(self._known(name))

    def touching(self, name: str) -> frozenset[tuple[str, str]]:
        """Return the fingertips that touch an object, each as hand and finger."""
        return frozenset(self._engine.touching(self._known(name)))

    def pressing(self, name: str) -> frozenset[str]:
        """Return the names of the other objects that press on an object.

        Raises:
            UsageError: The engine computes no contacts between objects.
        """
        from cbdsl.diagnostics.errors import UsageError

        # The kinematic engine has no contacts between objects.
        neighbours = getattr(self._engine, "neighbours", None)
        if neighbours is None:
            raise UsageError(
                "this engine computes no contacts between objects: use bullet or mujoco"
            )
        return frozenset(neighbours(self._known(name)))

    def fingertip_forces(self) -> dict[tuple[str, str], NDArray[np.float64]]:
        """Return the force of each fingertip, by hand and finger, on the world, N, shape (3,)."""
        # A wrench is a force, N, followed by a torque, Nm.
        wrenches = self._engine.wrenches()
        return {
            cell: wrench[:3].copy()
            for cell, wrench in zip(self._engine.cells, wrenches, strict=True)
        }

    def link_position(self, link: str) -> NDArray[np.float64]:
        """Return the position of a link of the robot, m, shape (3,)."""
        self._require(link, "link of the robot", self._engine.rows)
        return self._engine.link_pose(link).position

    def link_rotation(self, link: str) -> NDArray[np.float64]:
        """Return the axes of a link of the robot as columns, shape (3, 3)."""
        self._require(link, "link of the robot", self._engine.rows)
        return self._engine.link_pose(link).rotation

    def joint_positions(self) -> NDArray[np.float64]:
        """Return the positions of the actuated joints, rad or m, shape (n,)."""
        return self._engine.read()[0].copy()

    def joint_velocities(self) -> NDArray[np.float64]:
        """Return the velocities of the actuated joints, rad/s or m/s, shape (n,)."""
        return self._engine.read()[1].copy()

    def _known(self, name: str) -> str:
        self._require(name, "object in the world", self.objects)
        return name

    @staticmethod
    def _require(name: str, noun: str, known: Iterable[str]) -> None:
        from cbdsl.diagnostics.errors import UsageError

        names = list(known)
        if name not in names:
            raise UsageError.unknown(noun, name, names)

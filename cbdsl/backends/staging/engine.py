"""The engine interface: all that differs from one simulator to the next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.appearance import parts_of
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.world_state import Part
from cbdsl.sensing.observation import Cell

Floats = NDArray[np.float64]

#: What is put back keeps this far from the robot, m.
ROOM = 0.03


class Engine(ABC):
    """A robot and the objects of a stage in one simulator; it is the episode's ground truth.

    Attributes:
        cells: the load cells, as (hand, finger), in the robot file's order.
        rows: the row of each link of the robot in ``placements``.
        objects: what the stage has put into the world and not taken away, by name.
    """

    cells: tuple[Cell, ...]
    rows: Mapping[str, int]
    objects: Mapping[str, SceneObject]

    def names(self) -> tuple[str, ...]:
        """Names of the objects that are in the world."""
        return tuple(self.objects)

    def parts(self, name: str) -> list[Part]:
        """The visible parts of an object."""
        return parts_of(self.objects[name])

    def link_pose(self, link: str) -> Pose:
        """Pose of a link of the robot."""
        row = self.placements[self.rows[link]]
        return Pose(row[9:].copy(), row[:9].reshape(3, 3).copy())

    @abstractmethod
    def pose(self, name: str) -> Pose:
        """Pose of an object: its centre and axes."""

    @abstractmethod
    def velocity(self, name: str) -> Floats:
        """Velocity of an object's centre while nothing holds it, m/s, shape (3,)."""

    @abstractmethod
    def touched(self, name: str) -> bool:
        """Whether the robot touches an object."""

    @abstractmethod
    def touching(self, name: str) -> frozenset[Cell]:
        """The load cells whose fingertips touch an object."""

    @property
    @abstractmethod
    def solids(self) -> Floats:
        """Rows of all objects, see ``solids``, shape (k, 16).

        Always the same array, until an object comes or goes.
        """

    @property
    @abstractmethod
    def placements(self) -> Floats:
        """Rotation, row by row, then position, m, of all links, shape (links, 12)."""

    @abstractmethod
    def add(self, item: SceneObject) -> None:
        """Put an object into the world; without mass it does not move."""

    @abstractmethod
    def remove(self, name: str) -> None:
        """Take an object out of the world."""

    @abstractmethod
    def attach(self, name: str) -> None:
        """Hold an object where it is, whatever presses against it."""

    @abstractmethod
    def lead(self, name: str, position: Floats, velocity: Floats) -> None:
        """Lead an attached object: where it is to be now, m, and its velocity, m/s."""

    @abstractmethod
    def release(self, name: str) -> None:
        """Let go of an object at rest, if it is attached."""

    @abstractmethod
    def launch(self, name: str, velocity: Floats) -> None:
        """Give an object a velocity, m/s, shape (3,), without spin."""

    @abstractmethod
    def put_back(self, name: str, pose: Pose) -> None:
        """Put an object somewhere at rest, unless the robot is in the way."""

    @abstractmethod
    def begin(self, positions: Floats) -> None:
        """Empty the world but for the robot, its joints at rest at these positions, rad."""

    @abstractmethod
    def step(self, targets: Floats) -> None:
        """Advance by one physics step, the servos' targets being these, rad, shape (n,)."""

    @abstractmethod
    def read(self) -> tuple[Floats, Floats]:
        """Positions and velocities of the actuated joints, rad and rad/s, shape (n,) each."""

    @abstractmethod
    def wrenches(self) -> Floats:
        """Wrench that each fingertip exerts on the world, world frame, shape (cells, 6).

        Force, N, then torque about the fingertip's origin, N m.
        """

    @abstractmethod
    def efforts(self) -> Floats | None:
        """Torques of the servos in the last step, N m, shape (n,); ``None`` without forces."""

    @abstractmethod
    def close(self) -> None:
        """Free the simulator."""

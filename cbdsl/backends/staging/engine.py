"""Engine interface: all differences between simulators."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from cbdsl.backends.staging.appearance import parts_of
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.world_state import Part
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Cell

#: Least distance from the robot of an object that is put back, m.
ROOM = 0.03


class Engine(ABC):
    """Robot and objects of a stage in one simulator: the episode's ground truth.

    Attributes:
        cells: Load cells, as (hand, finger), in the robot file's order.
        rows: Row of each link of the robot in ``placements``.
        objects: Objects that the stage has added to the world and not removed, by name.
    """

    cells: tuple[Cell, ...]
    rows: Mapping[str, int]
    objects: Mapping[str, SceneObject]

    def names(self) -> tuple[str, ...]:
        """Return the names of the objects in the world."""
        return tuple(self.objects)

    def parts(self, name: str) -> list[Part]:
        """Return the visible parts of an object."""
        return parts_of(self.objects[name])

    def link_pose(self, link: str) -> Pose:
        """Return the pose of a link of the robot."""
        row = self.placements[self.rows[link]]
        return Pose(row[9:].copy(), row[:9].reshape(3, 3).copy())

    @abstractmethod
    def pose(self, name: str) -> Pose:
        """Return the pose of an object: its centre and axes."""

    @abstractmethod
    def velocity(self, name: str) -> Floats:
        """Return the velocity of an object's centre while it is not held, m/s, shape (3,)."""

    @abstractmethod
    def touched(self, name: str) -> bool:
        """Return whether the robot touches an object."""

    @abstractmethod
    def touching(self, name: str) -> frozenset[Cell]:
        """Return the load cells whose fingertips touch an object."""

    @property
    @abstractmethod
    def solids(self) -> Floats:
        """Rows of all objects, as in ``solids``, shape (k, 16).

        Always the same array until an object is added or removed.
        """

    @property
    @abstractmethod
    def placements(self) -> Floats:
        """Rotation by rows, then position, m, of all links, shape (links, 12)."""

    @abstractmethod
    def add(self, item: SceneObject) -> None:
        """Add an object to the world; without mass it does not move."""

    @abstractmethod
    def remove(self, name: str) -> None:
        """Remove an object from the world."""

    @abstractmethod
    def attach(self, name: str) -> None:
        """Hold an object where it is, against any force."""

    @abstractmethod
    def lead(self, name: str, position: Floats, velocity: Floats) -> None:
        """Lead an attached object to a position, m, at a velocity, m/s."""

    @abstractmethod
    def release(self, name: str) -> None:
        """Release an object at rest, if it is attached."""

    @abstractmethod
    def launch(self, name: str, velocity: Floats) -> None:
        """Give an object a velocity, m/s, shape (3,), without spin."""

    @abstractmethod
    def put_back(self, name: str, pose: Pose) -> None:
        """Place an object at rest at a pose, unless the robot is in the way."""

    @abstractmethod
    def begin(self, positions: Floats) -> None:
        """Remove all objects, and set the joints at rest at these positions, rad."""

    @abstractmethod
    def step(self, targets: Floats) -> None:
        """Advance by one physics step with these servo targets, rad, shape (n,)."""

    @abstractmethod
    def read(self) -> tuple[Floats, Floats]:
        """Return the actuated joints' positions and velocities, rad and rad/s, shape (n,) each."""

    @abstractmethod
    def wrenches(self) -> Floats:
        """Return each fingertip's wrench on the world, world frame, shape (cells, 6).

        Force, N, then torque about the fingertip's origin, N m.
        """

    @abstractmethod
    def efforts(self) -> Floats | None:
        """Return the servos' torques in the last step, N m, shape (n,); ``None`` without forces."""

    @abstractmethod
    def close(self) -> None:
        """Free the simulator."""

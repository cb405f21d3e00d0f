"""World state: what a backend tells recordings and tests of its world, and no controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from cbdsl.backends.staging.pose import Pose
from cbdsl.robot.mesh_reader import Mesh


class Part(NamedTuple):
    """A visible shape of an object.

    Attributes:
        shape: ``ball`` (radius), ``box`` (edge lengths), ``cylinder`` about z (radius, height), or
            ``mesh`` (nothing).
        size: as the shape needs it, m.
        position: of its centre in the object's frame, m.
        quaternion: of its axes in the object's frame, as (x, y, z, w).
        color: red, green and blue, each from 0 to 1.
        mesh: the triangles of a mesh.
    """

    shape: str
    size: tuple[float, ...]
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    color: tuple[float, ...]
    mesh: Mesh | None = None


class WorldState(Protocol):
    """The objects besides the robot that are in the world now."""

    def names(self) -> tuple[str, ...]:
        """Names of the objects that the stage has put into the world and not taken away."""
        ...

    def parts(self, name: str) -> Sequence[Part]:
        """The visible parts of an object."""
        ...

    def pose(self, name: str) -> Pose:
        """Pose of an object: its centre and axes."""
        ...


@runtime_checkable
class GroundTruthProvider(Protocol):
    """A backend that knows its world.

    Attributes:
        truth: the world of the current episode.
    """

    @property
    def truth(self) -> WorldState:
        """The world of the current episode."""
        ...

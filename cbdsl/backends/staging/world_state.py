"""World state: a backend's report on its world to recordings and tests, not to controllers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from cbdsl.kinematics.pose import Pose
from cbdsl.robot.meshes.mesh_reader import Mesh


class Part(NamedTuple):
    """Visible shape of an object.

    Attributes:
        shape: ``ball`` (radius), ``box`` (edge lengths), ``cylinder`` about z (radius, height), or
            ``mesh`` (nothing).
        size: Sizes that the shape needs, m.
        position: Position of its centre in the object's frame, m.
        quaternion: Quaternion of its axes in the object's frame, as (x, y, z, w).
        color: Red, green and blue, each from 0 to 1.
        mesh: Triangles of a mesh.
    """

    shape: str
    size: tuple[float, ...]
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    color: tuple[float, ...]
    mesh: Mesh | None = None


class WorldState(Protocol):
    """Objects besides the robot that are in the world now."""

    def names(self) -> tuple[str, ...]:
        """Return the names of the objects that the stage has added to the world and not removed."""
        ...

    def parts(self, name: str) -> Sequence[Part]:
        """Return the visible parts of an object."""
        ...

    def pose(self, name: str) -> Pose:
        """Return the pose of an object: its centre and axes."""
        ...


@runtime_checkable
class GroundTruthProvider(Protocol):
    """Backend that knows its world.

    Attributes:
        truth: World of the current episode.
    """

    @property
    def truth(self) -> WorldState:
        """World of the current episode."""
        ...

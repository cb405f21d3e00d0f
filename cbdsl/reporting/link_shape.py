"""A visible part of a link."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.robot.mesh_reader import Mesh

Numbers = tuple[float, ...]


class LinkShape(NamedTuple):
    """A visible part of a link.

    Attributes:
        shape: ``ball``, ``box``, ``cylinder`` or ``mesh``.
        size: radius; edge lengths; radius and height along z; for a mesh nothing; m.
        position: in the link's frame, m.
        quaternion: in the link's frame, as (x, y, z, w).
        color: red, green and blue, each from 0 to 1.
        mesh: the triangles of a mesh.
    """

    shape: str
    size: Numbers
    position: Numbers
    quaternion: Numbers
    color: Numbers
    mesh: Mesh | None = None

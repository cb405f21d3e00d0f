"""Visible part of a link."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.robot.meshes.mesh_reader import Mesh

Numbers = tuple[float, ...]


class LinkShape(NamedTuple):
    """Visible part of a link.

    Attributes:
        shape: ``ball``, ``box``, ``cylinder`` or ``mesh``.
        size: Radius of a ball, edge lengths of a box, radius and height along z of a cylinder, m;
            empty for a mesh.
        position: Position in the link's frame, m.
        quaternion: Orientation in the link's frame, as (x, y, z, w).
        color: Red, green and blue, each from 0 to 1.
        mesh: Triangles of a mesh.
    """

    shape: str
    size: Numbers
    position: Numbers
    quaternion: Numbers
    color: Numbers
    mesh: Mesh | None = None

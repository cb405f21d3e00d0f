"""Triangle meshes of the unit primitives and of objects, for the graphics card."""

from __future__ import annotations

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.robot.meshes.mesh_reader import Mesh

_SIDES = 48
_SPLITS = 3


def ball() -> Floats:
    """Return triangles of the unit ball with their normals, shape (triangles, 3, 6).

    The faces of an octahedron are repeatedly split into four and projected onto the sphere.
    """
    # Each octant has one triangle, with a corner on each of its half axes.
    signs = np.array(np.meshgrid([1, -1], [1, -1], [1, -1])).reshape(3, -1).T
    triangles = signs[:, :, None] * np.eye(3)
    for _ in range(_SPLITS + 1):
        a, b, c = np.moveaxis(triangles, 1, 0)
        ab, bc, ca = (_on_sphere(middle) for middle in (a + b, b + c, c + a))
        corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(corner, axis=1) for corner in corners])
    # On a unit ball, the normal of a corner is the corner itself.
    return np.concatenate([triangles, triangles], axis=2)


def _on_sphere(points: Floats) -> Floats:
    lengths: Floats = np.linalg.norm(points, axis=-1, keepdims=True)
    return points / lengths


def box() -> Floats:
    """Return triangles of the box from -1 to 1 on each axis, with normals, shape (12, 3, 6)."""
    face = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]], dtype=float)
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            # Opposite faces differ in the order of their corners. The renderer draws both sides of
            # a triangle.
            corners = np.insert(face, axis, sign, axis=1)
            normals = np.tile(sign * np.eye(3)[axis], (6, 1))
            sides.append(np.hstack([corners, normals]).reshape(2, 3, 6))
    return np.concatenate(sides)


def cylinder() -> Floats:
    """Return triangles of the z cylinder of radius 1, from -1 to 1, shape (triangles, 3, 6)."""
    angles = np.linspace(0, 2 * np.pi, _SIDES + 1)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    here, there, up = rim[:-1], rim[1:], np.array([0.0, 0.0, 1.0])
    wall = [
        _with_normals((here - up, there - up, there + up), (here, there, there)),
        _with_normals((here - up, there + up, here + up), (here, there, here)),
    ]
    lids = [
        _with_normals((here + end, there + end, np.tile(end, (_SIDES, 1))), (end, end, end))
        for end in (up, -up)
    ]
    return np.concatenate(wall + lids)


def flat(mesh: Mesh) -> Floats:
    """Return a mesh's triangles, each with the normal of its plane, shape (triangles, 3, 6)."""
    corners = mesh.corners[mesh.triangles]
    a, b, c = np.moveaxis(corners, 1, 0)
    normals: Floats = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return np.concatenate((corners, np.repeat(normals[:, None], 3, axis=1)), axis=2)


def _with_normals(corners: tuple[Floats, ...], normals: tuple[Floats, ...]) -> Floats:
    pairs = [
        np.hstack([corner, np.broadcast_to(normal, corner.shape)])
        for corner, normal in zip(corners, normals, strict=True)
    ]
    return np.stack(pairs, axis=1)

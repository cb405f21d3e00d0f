"""The unit meshes: closed, of the right volume, lit from outside."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.backends.cameras import primitive_mesh as mesh

MESHES = [(mesh.ball, 4 * np.pi / 3), (mesh.box, 8.0), (mesh.cylinder, 2 * np.pi)]


@pytest.mark.parametrize(("make", "volume"), MESHES)
def test_triangles_enclose_the_solid(make: Callable[[], np.ndarray], volume: float) -> None:
    triangles = make()[:, :, :3]
    normals = make()[:, :, 3:].mean(axis=1)
    a, b, c = np.moveaxis(triangles, 1, 0)
    # For either winding order of a triangle, its normal points to the outside.
    outward = np.sign(np.einsum("ij,ij->i", np.cross(b - a, c - a), normals))
    sixths = outward * np.einsum("ij,ij->i", a, np.cross(b, c))
    assert sixths.sum() / 6 == pytest.approx(volume, rel=0.01)


@pytest.mark.parametrize(("make", "volume"), MESHES)
def test_every_edge_joins_two_triangles(make: Callable[[], np.ndarray], volume: float) -> None:
    corners = np.round(make()[:, :, :3], 6) + 0.0
    edges: dict[frozenset[tuple[float, ...]], int] = {}
    for triangle in corners:
        points = [tuple(corner) for corner in triangle]
        if len(set(points)) < 3:
            continue
        for i in range(3):
            edge = frozenset((points[i], points[(i + 1) % 3]))
            edges[edge] = edges.get(edge, 0) + 1
    assert set(edges.values()) == {2}


@pytest.mark.parametrize(("make", "volume"), MESHES)
def test_normals_are_units_that_point_outward(
    make: Callable[[], np.ndarray], volume: float
) -> None:
    corners, normals = np.split(make().reshape(-1, 6), 2, axis=1)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
    assert (np.einsum("ij,ij->i", corners, normals) >= 0).all()

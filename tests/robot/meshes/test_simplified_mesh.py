"""Meshes: found by every kind of name, reduced in size, with the same shape."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.cameras import primitive_mesh as primitives
from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.robot.meshes.simplified_mesh import DEVIATION, read_simplified, simplified


def from_soup(triangles: np.ndarray) -> Mesh:
    """Return a mesh of separate triangles, shape (triangles, 3, 3)."""
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def area(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.corners[mesh.triangles], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def distance(point: np.ndarray, mesh: Mesh) -> float:
    """Return the distance from a point to a mesh, whose triangles are sampled densely."""
    steps = np.linspace(0.0, 1.0, 41)
    u, v = (grid[np.add.outer(steps, steps) <= 1.0] for grid in np.meshgrid(steps, steps))
    a, b, c = np.moveaxis(mesh.corners[mesh.triangles], 1, 0)
    points = a[:, None] + u[:, None] * (b - a)[:, None] + v[:, None] * (c - a)[:, None]
    return float(np.linalg.norm(points - point, axis=-1).min())


def rods_between_plates(count: int, radius: float, rng: np.random.Generator) -> Mesh:
    """Return two plates with thin rods between them: vertex clustering alone removes the rods."""
    plates = [primitives.box()[..., :3] * (0.5, 0.5, 0.02) + (0, 0, z) for z in (-1.0, 1.0)]
    rods = [
        primitives.cylinder()[..., :3] * (radius, radius, 1.0) + (*rng.uniform(-0.4, 0.4, 2), 0.0)
        for _ in range(count)
    ]
    return from_soup(np.concatenate([*plates, *rods]))


@pytest.mark.parametrize("radius", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("seed", range(3))
def test_simplified_mesh_deviates_within_its_bound_in_both_directions(
    radius: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    mesh = rods_between_plates(3, radius, rng)
    small, longest = simplified(mesh), float(np.ptp(mesh.corners, axis=0).max())
    for one, other in ((mesh, small), (small, mesh)):
        for row in rng.choice(one.triangles, 40):
            point = rng.dirichlet((1.0, 1.0, 1.0)) @ one.corners[row]
            # Half the distance of the samples on the longest triangles is 0.025.
            assert distance(point, other) <= DEVIATION * longest + 0.026


def test_fine_mesh_becomes_small_and_keeps_its_shape() -> None:
    ball = primitives.ball()[..., :3]
    small = simplified(from_soup(ball))
    fine = simplified(from_soup(ball + 1e-7))
    assert len(small.corners) < len(ball) and len(fine.triangles) <= len(ball)
    assert np.linalg.norm(small.corners, axis=1) == pytest.approx(1.0, abs=2 * DEVIATION)
    assert area(small) == pytest.approx(4 * np.pi, rel=0.06)


def test_coarse_mesh_keeps_every_triangle() -> None:
    box = from_soup(primitives.box()[..., :3])
    small = simplified(box)
    assert len(small.triangles) == 12 and len(small.corners) == 8
    assert area(small) == pytest.approx(24.0)


def test_mesh_is_read_with_its_scale(tmp_path: Path) -> None:
    file = tmp_path / "tile.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    mesh = read_simplified(file, (2.0, 3.0, 1.0))
    assert mesh is not None
    assert sorted(map(tuple, mesh.corners.round(9))) == [(0, 0, 0), (0, 3, 0), (2, 0, 0)]


def test_file_without_a_mesh_is_omitted(tmp_path: Path) -> None:
    file = tmp_path / "not.stl"
    file.write_bytes(b"nothing of the kind")
    assert read_simplified(file, (1.0, 1.0, 1.0)) is None


@pytest.mark.parametrize(
    "name", ["meshes/a b.stl", "meshes/a%20b.stl", "package://arm/meshes/a b.stl", "file://{}"]
)
def test_mesh_files_are_found_by_every_kind_of_path(name: str, tmp_path: Path) -> None:
    file = tmp_path / "arm" / "meshes" / "a b.stl"
    file.parent.mkdir(parents=True)
    file.touch()
    (tmp_path / "arm" / "urdf").mkdir()
    folder = tmp_path / "arm" / ("urdf" if "package" in name else "")
    assert find_mesh(name.format(file), folder) == file


def test_package_that_is_not_above_is_not_found(tmp_path: Path) -> None:
    assert find_mesh("package://arm/a.stl", tmp_path) is None
    assert find_mesh("package://arm", tmp_path) is None

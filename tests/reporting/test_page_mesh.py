"""Meshes: found by every kind of name, reduced in size, with the same shape."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.cameras import primitive_mesh as primitives
from cbdsl.reporting.page_mesh import read_mesh
from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.robot.meshes.simplified_mesh import simplified


def from_soup(triangles: np.ndarray) -> Mesh:
    """Return a mesh of separate triangles, shape (triangles, 3, 3)."""
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def area(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.corners[mesh.triangles], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_a_fine_mesh_becomes_small_and_keeps_its_shape() -> None:
    ball = primitives.ball()[..., :3]
    assert len(ball) > 2000
    small = simplified(from_soup(ball))
    assert len(small.triangles) <= 1500
    assert np.linalg.norm(small.corners, axis=1) == pytest.approx(1.0, abs=0.05)
    assert area(small) == pytest.approx(4 * np.pi, rel=0.06)


def test_a_coarse_mesh_keeps_every_triangle() -> None:
    box = from_soup(primitives.box()[..., :3])
    small = simplified(box)
    assert len(small.triangles) == 12 and len(small.corners) == 8
    assert area(small) == pytest.approx(24.0)


def test_a_mesh_is_read_with_its_scale(tmp_path: Path) -> None:
    file = tmp_path / "tile.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    mesh = read_mesh(file, (2.0, 3.0, 1.0))
    assert mesh is not None
    assert sorted(map(tuple, mesh.corners.round(9))) == [(0, 0, 0), (0, 3, 0), (2, 0, 0)]


def test_file_without_a_mesh_is_omitted(tmp_path: Path) -> None:
    file = tmp_path / "not.stl"
    file.write_bytes(b"nothing of the kind")
    assert read_mesh(file, (1.0, 1.0, 1.0)) is None


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


def test_a_package_that_is_not_above_is_not_found(tmp_path: Path) -> None:
    assert find_mesh("package://arm/a.stl", tmp_path) is None
    assert find_mesh("package://arm", tmp_path) is None

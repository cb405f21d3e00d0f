"""Meshes of things: in the middle of the box around them, seen from outside."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.robot.meshes.thing_mesh import read_thing_mesh

_CORNERS = "v 1 0 0\nv 3 0 0\nv 1 4 0\nv 1 0 6\n"
_OUTWARD = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
_INWARD = "f 2 3 1\nf 4 2 1\nf 3 4 1\nf 4 3 2\n"


@pytest.mark.parametrize("faces", [_OUTWARD, _INWARD])
def test_mesh_is_in_the_middle_and_turned_outwards(tmp_path: Path, faces: str) -> None:
    file = tmp_path / "corner.obj"
    file.write_text(_CORNERS + faces)
    mesh, halves = read_thing_mesh(file, 0.01)
    assert halves == pytest.approx((0.01, 0.02, 0.03))
    assert mesh.corners.min(axis=0) == pytest.approx(-np.array(halves))
    a, b, c = np.moveaxis(mesh.corners[mesh.triangles], 1, 0)
    assert np.sum(a * np.cross(b, c)) / 6 == pytest.approx(8e-6), "its volume, by outward faces"


def test_mesh_that_has_changed_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "corner.obj"
    file.write_text(_CORNERS + _OUTWARD)
    before = read_thing_mesh(file, 0.01).halves
    file.write_text(_CORNERS.replace("v 3", "v 5") + _OUTWARD)
    os.utime(file, ns=(1, 1))
    assert read_thing_mesh(file, 0.01).halves == pytest.approx((2 * before[0], *before[1:]))


def test_missing_mesh_is_reported(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no such mesh"):
        read_thing_mesh(tmp_path / "nothing.obj", 1.0)

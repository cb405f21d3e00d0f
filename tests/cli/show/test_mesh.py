"""``cb show mesh``: forms of meshes, and files that contain no valid mesh."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml

from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.stage import ThingSection
from tests.cli.test_main import cb
from tests.numeric.test_box_cover import cuboid


class Result(NamedTuple):
    code: int
    out: str
    err: str


Run = Callable[..., Result]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    def run(*words: str) -> Result:
        code = cb(monkeypatch, *words)
        return Result(int(code or 0), *capsys.readouterr())

    return run


def write_stl(file: Path, triangles: np.ndarray) -> Path:
    """Write triangles as a binary STL file."""
    records = np.zeros(len(triangles), [("normal", "<f4", 3), ("at", "<f4", (3, 3)), ("no", "<u2")])
    records["at"] = triangles
    file.write_bytes(bytes(80) + len(triangles).to_bytes(4, "little") + records.tobytes())
    return file


def gutter() -> np.ndarray:
    """Return three adjacent cuboids with a lower one in the middle, mm."""
    parts = [(0, 20, 60), (20, 60, 20), (60, 80, 60)]
    return np.concatenate([cuboid((a, 0, 0), (b, 100, c)) for a, b, c in parts])


def test_mesh_becomes_the_form_of_a_thing(run: Run, tmp_path: Path) -> None:
    file = write_stl(tmp_path / "gutter.stl", gutter())
    result = run("show", "mesh", str(file), "--scale", "0.001")
    assert result.code == 0
    assert "3 boxes, which fill 100 % of gutter.stl" in result.out
    thing = ThingSection.model_validate({"mass": 0.2, **yaml.safe_load(result.out)})
    shape = SolidShape.draw(thing.form, np.random.default_rng(0))
    assert shape.halves == pytest.approx((0.04, 0.05, 0.03), abs=2e-3)
    assert shape.volume == pytest.approx(0.1 * (2 * 0.02 * 0.06 + 0.04 * 0.02), rel=0.1)


@pytest.mark.parametrize(
    ("name", "data", "problem"),
    [
        ("none.stl", None, "there is no such mesh"),
        ("thing.ply", b"ply", "not a mesh of a known format; known: .stl, .obj"),
        ("thing.obj", b"v 0 0 0\nf 1 2 3\n", "names a point that is not there"),
        ("thing.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not closed: 3 edges"),
        ("thing.stl", b"", "a mesh without triangles"),
        ("thing.stl", b"\xff" * 100, "not a mesh"),
    ],
)
def test_invalid_mesh_is_reported(
    run: Run, tmp_path: Path, name: str, data: bytes | None, problem: str
) -> None:
    if data is not None:
        (tmp_path / name).write_bytes(data)
    result = run("show", "mesh", str(tmp_path / name))
    assert result.code == 2
    assert problem in result.err and "Traceback" not in result.err


def test_mesh_in_millimetres_is_too_large_for_a_thing(run: Run, tmp_path: Path) -> None:
    result = run("show", "mesh", str(write_stl(tmp_path / "gutter.stl", gutter())))
    assert result.code == 2
    assert "100 m long; things are 1 mm to 2 m" in result.err and "--scale" in result.err

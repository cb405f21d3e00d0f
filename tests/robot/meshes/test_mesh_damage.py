"""Damage of mesh files, in each format."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import pytest

from cbdsl.robot.meshes import model_meshes
from cbdsl.robot.meshes.mesh_damage import MOST_BYTES, mesh_damage
from cbdsl.robot.meshes.model_meshes import damaged_meshes, missing_meshes
from cbdsl.robot.urdf_reader import parse_urdf
from tests.robot.meshes.samples import DAMAGED, SOUND


def damage_of(folder: Path, name: str, data: bytes) -> str:
    file = folder / name
    file.write_bytes(data)
    return mesh_damage(file)


@pytest.mark.parametrize("name", SOUND)
def test_mesh_damage_of_sound_mesh_is_empty(name: str, tmp_path: Path) -> None:
    assert damage_of(tmp_path, name, SOUND[name]) == ""
    assert damage_of(tmp_path, name.upper(), SOUND[name]) == ""


@pytest.mark.parametrize(("name", "damage"), DAMAGED)
def test_mesh_damage_of_damaged_mesh_is_one_printable_line(
    name: str, damage: str, tmp_path: Path
) -> None:
    found = damage_of(tmp_path, name, DAMAGED[name, damage])
    assert found and len(found) < 200 and found.isprintable()


@pytest.mark.parametrize("name", [name for name in SOUND if name != "tip.obj"])
def test_mesh_damage_of_any_truncation_is_found(name: str, tmp_path: Path) -> None:
    """Cut a file anywhere but in its trailing white space. Nothing ends an OBJ."""
    data = SOUND[name].rstrip() if name.endswith((".stl", ".dae")) else SOUND[name]
    ends = len(data) - len(b" tip") if name == "text.stl" else len(data)
    # The counts of a PLY are bounds, which a cut in its last numbers does not reach.
    ends = data.index(b"end_header") + 20 if name == "tip.ply" else ends
    assert not [end for end in range(0, ends, 7) if not damage_of(tmp_path, name, data[:end])]


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.obj", b"v 0 0 0 1 0 0\r\nv 1. .5 -1e-3\r\nv 0 1E2 +3\r\nf 1//2 2/3/4 -1 # last\r\n"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n 2 3\nl 1 2\n"),
        ("a.stl", b"solid named like a text".ljust(80) + struct.pack("<I", 1) + bytes(50)),
        ("a.stl", b"SOLID A\nFACET NORMAL NAN 0 0\n" + b"VERTEX 1E+000 0 0\n" * 3 + b"ENDSOLID"),
        ("a.xyz", b"a format of which nothing is known"),
    ],
)
def test_mesh_damage_of_unusual_sound_mesh_is_empty(name: str, data: bytes, tmp_path: Path) -> None:
    assert damage_of(tmp_path, name, data) == ""


@pytest.mark.parametrize(
    ("name", "data", "damage"),
    [
        ("a.obj", b"v 0 0\n", "line 1, 'v 0 0', is no point of three finite numbers"),
        ("a.obj", b"v 0 0 0\n\nv 0 nan 0\n", "line 3, 'v 0 nan 0'"),
        ("a.obj", b"v 0 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 4\n", "a face names point 4, and it has 3"),
        ("a.obj", b"v 0 0 0\nv 0 0 1\nv 0 1 0\nf 0 1 2\n", "a face names point 0"),
        ("a.obj", b"v 0 0 0\nf 1 x 3\n", "line 2, 'f 1 x 3', is no face"),
        ("a.obj", b"v 0 0 0\0\n", "bytes of value 0"),
        ("a.stl", bytes(80) + b"\xff" * 4, "a binary STL of 4294967295 triangles has"),
        ("a.stl", b"solid\nfacet\nvertex 0 0 0\nendsolid", "1 facets and 1 corners"),
        ("a.dae", b"<COLLADA><mesh>", "it is not XML"),
        ("a.dae", b"<html/>", "its root is <html>, not <COLLADA>"),
        ("a.dae", b'<!DOCTYPE a [<!ENTITY x "y">]><COLLADA/>', "entities"),
        ("a.dae", b'<COLLADA><float_array count="2">1 inf</float_array></COLLADA>', "'inf' is no"),
        ("a.dae", b"<COLLADA><triangles><p>0 1 x</p></triangles></COLLADA>", "'x' is no index"),
        ("a.stl", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
    ],
)
def test_mesh_damage_states_the_place(name: str, data: bytes, damage: str, tmp_path: Path) -> None:
    assert damage in damage_of(tmp_path, name, data)


def test_mesh_damage_of_file_that_is_too_large_opens_nothing(tmp_path: Path) -> None:
    file = tmp_path / "a.stl"
    with file.open("wb") as sparse:
        sparse.truncate(MOST_BYTES + 1)
    assert "larger than 100000000 bytes" in mesh_damage(file)
    assert mesh_damage(tmp_path) == "it is a folder"
    assert mesh_damage(tmp_path / "none.stl")
    os.mkfifo(tmp_path / "pipe.stl")
    assert mesh_damage(tmp_path / "pipe.stl") == "it is a named pipe"


def test_damaged_meshes_of_large_model_reads_the_smallest_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shapes = ""
    for name, size in (("large", 300), ("small", 100), ("middle", 200), ("none", 0)):
        if size:
            (tmp_path / f"{name}.obj").write_bytes(b"x" * size)
        shapes += f'<visual><geometry><mesh filename="{name}.obj"/></geometry></visual>'
    text = f'<robot name="a"><link name="base">{shapes}</link></robot>'
    model = parse_urdf(text, tmp_path / "a.urdf")
    assert [fault.file for fault in missing_meshes(model)] == ["none.obj"]
    for most, expected in (
        (1000, ["large.obj", "small.obj", "middle.obj"]),
        (300, ["small.obj", "middle.obj"]),
        # Each file beyond the bound by itself is a fault.
        (250, ["large.obj", "small.obj"]),
    ):
        monkeypatch.setattr(model_meshes, "MOST_BYTES", most)
        assert [fault.file for fault in damaged_meshes(model)] == expected

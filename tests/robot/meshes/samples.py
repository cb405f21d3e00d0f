"""Sound meshes of a tetrahedron in each format, and kinds of damage."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping

_CORNERS = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
_POINTS = "".join(f"{x} {y} {z}\n" for x, y, z in _CORNERS)


def _obj() -> bytes:
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in _CORNERS)
    return (points + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in _FACES)).encode()


def _stl() -> bytes:
    records = (
        struct.pack("<12f2x", 0, 0, 0, *(value for k in face for value in _CORNERS[k]))
        for face in _FACES
    )
    return bytes(80) + struct.pack("<I", len(_FACES)) + b"".join(records)


def _stl_text() -> bytes:
    facets = (
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*_CORNERS[k]) for k in face)
        + "endloop\nendfacet\n"
        for face in _FACES
    )
    return f"solid tip\n{''.join(facets)}endsolid tip\n".encode()


def _dae() -> bytes:
    places = " ".join(_POINTS.split())
    indices = " ".join(str(k) for face in _FACES for k in face)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="1" name="meter"/><up_axis>Z_UP</up_axis></asset>
  <library_geometries><geometry id="g" name="g"><mesh>
    <source id="p"><float_array id="pa" count="12">{places}</float_array>
      <technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
        <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
    </source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p>
    </triangles></mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>""".encode()


def _ply() -> bytes:
    head = (
        f"ply\nformat ascii 1.0\nelement vertex {len(_CORNERS)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(_FACES)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return (head + _POINTS + "".join(f"3 {a} {b} {c}\n" for a, b, c in _FACES)).encode()


def _glb() -> bytes:
    points = b"".join(struct.pack("<3f", *corner) for corner in _CORNERS)
    indices = b"".join(struct.pack("<3H", *face) for face in _FACES)
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [0, 0, 0], "max": [0.1, 0.1, 0.1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(points) + len(indices)}],
    }).encode()  # fmt: skip
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(points) + len(indices), b"BIN\0") + points + indices
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


#: Sound mesh by the name of its file.
SOUND: Mapping[str, bytes] = {
    "tip.obj": _obj(),
    "tip.stl": _stl(),
    "text.stl": _stl_text(),
    "tip.dae": _dae(),
    "tip.ply": _ply(),
    "tip.glb": _glb(),
}
_NO_TRIANGLES = {
    "tip.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "tip.stl": bytes(84),
    "text.stl": b"solid tip\nendsolid tip\n",
    "tip.dae": b"<COLLADA><library_geometries/></COLLADA>",
    "tip.ply": b"ply\nformat ascii 1.0\nelement vertex 0\nelement face 0\nend_header\n",
    "tip.glb": b"glTF" + struct.pack("<II", 2, 13) + b" ",
}
_LFS = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 4242\n"


def _not_finite(name: str, data: bytes) -> bytes | None:
    if name == "tip.stl":
        return data[:96] + struct.pack("<f", float("nan")) + data[100:]
    return data.replace(b"0.1", b"nan", 1) if name not in ("tip.ply", "tip.glb") else None


def _too_large_numbers(name: str, data: bytes) -> bytes | None:
    if name == "tip.stl":
        return data[:96] + struct.pack("<f", float("inf")) + data[100:]
    return data.replace(b"0.1", b"1e999", 1) if name not in ("tip.ply", "tip.glb") else None


def _larger_declared(name: str, data: bytes) -> bytes | None:
    if name == "tip.stl":
        return data[:80] + b"\xff\xff\xff\xff" + data[84:]
    if name == "tip.glb":
        return data[:8] + b"\xff\xff\xff\xff" + data[12:]
    declared = {
        "tip.dae": (b'count="12"', b'count="99999999999999999999999"'),
        "tip.ply": (b"vertex 4", b"vertex 4000000000"),
        "tip.obj": (b"f 1", b"f 4000000000"),
    }
    return data.replace(*declared[name], 1) if name in declared else None


#: Damage by its name: a function of a file's name and sound bytes; ``None`` where it has none.
DAMAGE: Mapping[str, Callable[[str, bytes], bytes | None]] = {
    "empty": lambda name, data: b"",
    "truncated": lambda name, data: data[: 2 * len(data) // 5],
    "garbage": lambda name, data: bytes(range(255, -1, -1)) * 3,
    "text": lambda name, data: b"404: Not Found\n",
    "pointer": lambda name, data: _LFS,
    "not finite": _not_finite,
    "too large numbers": _too_large_numbers,
    "larger declared": _larger_declared,
    "no triangles": lambda name, data: _NO_TRIANGLES[name],
}

#: Every pair of a format and a damage that it can have.
DAMAGED: Mapping[tuple[str, str], bytes] = {
    (name, damage): data
    for name, sound in SOUND.items()
    for damage, spoil in DAMAGE.items()
    if (data := spoil(name, sound)) is not None
}

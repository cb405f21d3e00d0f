"""Damage of mesh files, found without a native reader.

Engines differ about damaged meshes: one refuses them, one leaves them out, and one never opens
them. Documents are checked instead, before an engine opens the model. The check reads a file once,
by regular expressions and slices, in a time in proportion to its size. It needs no NumPy, which the
base installation lacks. It proves no mesh sound: it finds the damage of interrupted downloads and
failed exports, and files of another format.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from xml.parsers import expat

from cbdsl.diagnostics.legible_text import legible
from cbdsl.diagnostics.reason import reason
from cbdsl.storage.contents import contents

#: Pattern of a decimal number below 1e30. Possessive quantifiers keep its time linear.
DECIMAL = r"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE](?:-\d++|\+?(?=\d)0*+(?:[12]?\d)?(?!\d)))?+"


_FACES = ("triangles", "polylist", "polygons", "trifans", "tristrips")
_NO_NUMBER = re.compile(rf"(?<!\S)(?!{DECIMAL}(?!\S))\S++")
_NO_INDEX = re.compile(r"(?<!\S)(?!\d++(?!\S))\S++")


class ColladaError(ValueError):
    """Damage of a mesh; the message is a clause."""


def collada_damage(data: bytes) -> str:
    """Return the damage of a COLLADA file as a clause; empty without one."""
    reader = _Reader()
    parser = expat.ParserCreate()
    parser.buffer_text, parser.buffer_size = True, 1 << 16
    parser.EntityDeclHandler = _refuse_entity
    parser.StartElementHandler, parser.EndElementHandler = reader.start, reader.end
    parser.CharacterDataHandler = reader.text
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        return f"it is not XML, the format of COLLADA: {error}"
    except (LookupError, ValueError) as error:
        return str(error)
    return "" if reader.has_faces else "it has no triangles"


def _refuse_entity(*_: object) -> None:
    raise ColladaError("it declares XML entities, which models may not")


class _Reader:
    """Handlers of the parser's events, which keep the text of one element at a time.

    Attributes:
        has_faces: True if an element with triangles or polygons was read.
    """

    def __init__(self) -> None:
        self.has_faces = False
        self._is_root, self._in_faces = True, False
        self._pieces: list[str] | None = None
        self._declared = ""

    def start(self, tag: str, attributes: Mapping[str, str]) -> None:
        name = tag.rpartition(":")[2]
        if self._is_root and name != "COLLADA":
            raise ColladaError(f"its root is <{legible(tag)[:60]}>, not <COLLADA>")
        self._is_root = False
        self._in_faces = self._in_faces or name in _FACES
        if name == "float_array" or (name == "p" and self._in_faces):
            self._pieces, self._declared = [], attributes.get("count", "0")

    def text(self, text: str) -> None:
        if self._pieces is not None:
            self._pieces.append(text)

    def end(self, tag: str) -> None:
        name = tag.rpartition(":")[2]
        if name in _FACES:
            self._in_faces = False
        if self._pieces is None:
            return
        text, self._pieces = "".join(self._pieces), None
        if name == "p":
            self._require_none(_NO_INDEX, text, "no index of a point")
            self.has_faces = self.has_faces or bool(text.strip())
        else:
            self._require_none(_NO_NUMBER, text, "no finite number below 1e30")
            self._require_declared(len(text.split()))

    @staticmethod
    def _require_none(wrong: re.Pattern[str], text: str, kind: str) -> None:
        token = wrong.search(text)
        if token is not None:
            raise ColladaError(f"'{legible(token[0][:40])}' is {kind}")

    def _require_declared(self, numbers: int) -> None:
        declared = self._declared.strip()
        if not (declared.isascii() and declared.isdigit()) or int(declared[:20]) > numbers:
            raise ColladaError(
                f"an array declares {legible(declared[:20]) or 'no'} numbers and has {numbers}"
            )


#: Largest size of a mesh file, bytes.
MOST_BYTES = 100_000_000
_LFS = b"version https://git-lfs.github.com/spec/"
_EMPTY = "it has no triangles"
_NUL = "it has bytes of value 0, which no text has"
# Binary STL: a header, the number of triangles, and a record for each: a normal, three corners of
# three 32-bit numbers, and two unused bytes.
_STL_HEAD, _STL_RECORD, _STL_CORNERS = 84, 50, range(12, 48, 4)
_POINT = rf"(?:[ \t]++{DECIMAL}){{3}}(?=[ \t\r\n]|\Z)"
_NO_VERTEX = re.compile(rf"^[ \t]*+vertex\b(?!{_POINT})".encode(), re.MULTILINE)
_VERTEX = re.compile(rb"^[ \t]*+vertex\b", re.MULTILINE)
_FACET = re.compile(rb"^[ \t]*+facet\b", re.MULTILINE)
_NO_OBJ_POINT = re.compile(rf"^[ \t]*+v(?=[ \t\r\n])(?!{_POINT})".encode(), re.MULTILINE)
_OBJ_POINT = re.compile(rb"^[ \t]*+v[ \t]", re.MULTILINE)
# A corner of a face is the index of its point, and those of a texture and a normal, as in "7/2/5".
_NO_FACE = re.compile(
    rb"^[ \t]*+f(?=[ \t\r\n])(?!(?:[ \t]++-?\d++(?:/[-\d/]*+)?+){2,}+[ \t\r]*+(?:#|$))",
    re.MULTILINE,
)
_FACE = re.compile(rb"^[ \t]*+f([ \t].*)$", re.MULTILINE)
_INDEX = re.compile(rb"[ \t](-?\d+)")


def mesh_damage(file: Path) -> str:
    """Return the damage of a mesh file as a clause; empty without one.

    The format follows from the ending of the name. A file of another format is only damaged if it
    is empty.
    """
    try:
        status = file.stat()
        return _damage(file, status.st_size, status.st_mtime_ns)
    except OSError as error:
        return reason(error)


@lru_cache(maxsize=4096)
def _damage(file: Path, _size: int, _changed: int) -> str:
    data = contents(file, MOST_BYTES)
    if not data:
        return "it is empty"
    if data.startswith(_LFS):
        return "it is a pointer of Git LFS, not the mesh itself, which `git lfs pull` fetches"
    return _CHECKS.get(file.suffix.lower(), _no_damage)(data)


def _no_damage(_: bytes) -> str:
    return ""


def _stl(data: bytes) -> str:
    # A binary file, too, may begin with "solid".
    begins = data[:_STL_HEAD].lstrip()[:5].lower() == b"solid"
    count = int.from_bytes(data[_STL_HEAD - 4 : _STL_HEAD], "little")
    length = _STL_HEAD + count * _STL_RECORD
    if begins and len(data) != length and b"\0" not in data[:_STL_HEAD]:
        return _stl_text(data.lower())
    if len(data) < length or len(data) < _STL_HEAD:
        return (
            f"it has {len(data)} bytes, and a binary STL of {count} triangles has {length}"
            if len(data) >= _STL_HEAD
            else f"it has {len(data)} bytes, and each STL has a header: {_STL_HEAD} bytes or a text"
        )
    if not count:
        return _EMPTY
    for place in _STL_CORNERS:
        # The last byte of a number holds its sign and the upper seven bits of its exponent, which
        # are all ones if it is infinite, no number, or beyond 1.7e38.
        last = data[_STL_HEAD + place + 3 : length : _STL_RECORD]
        if b"\x7f" in last or b"\xff" in last:
            return "a corner of a triangle is not finite"
    return ""


def _stl_text(text: bytes) -> str:
    if b"\0" in text:
        return _NUL
    wrong = _NO_VERTEX.search(text)
    if wrong is not None:
        return _no_point(text, wrong.start())
    corners, facets = len(_VERTEX.findall(text)), len(_FACET.findall(text))
    if corners != 3 * facets:
        return f"it has {facets} facets and {corners} corners, and a facet has 3"
    if b"endsolid" not in text:
        return "it ends before 'endsolid'"
    return "" if facets else _EMPTY


def _obj(data: bytes) -> str:
    if b"\0" in data:
        return _NUL
    # A line may go on behind a backslash.
    text = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ") if b"\\" in data else data
    wrong = _NO_OBJ_POINT.search(text)
    if wrong is not None:
        return _no_point(text, wrong.start())
    wrong = _NO_FACE.search(text)
    if wrong is not None:
        return f"{_line(text, wrong.start())} is no face of points"
    points = len(_OBJ_POINT.findall(text))
    indices = [int(i) for i in _INDEX.findall(b"\n".join(_FACE.findall(text))) if len(i) < 20]
    if not indices:
        return _EMPTY
    wrong_index = next((i for i in (max(indices), min(indices)) if abs(i) > points), 0)
    if wrong_index or 0 in indices:
        return f"a face names point {wrong_index}, and it has {points}"
    return ""


def _ply(data: bytes) -> str:
    head, end, body = data.partition(b"end_header")
    if not head.startswith(b"ply") or not end:
        return "it has no header of PLY, from 'ply' to 'end_header'"
    counts = dict(re.findall(rb"^element[ \t]+(\w+)[ \t]+(\d{1,19})[ \t\r]*$", head, re.MULTILINE))
    points, faces = int(counts.get(b"vertex", 0)), int(counts.get(b"face", 0))
    # A point has three numbers of at least a byte, and a face a count and three indices.
    if len(body) < 3 * points + 4 * faces:
        return f"it declares {points} points and {faces} faces, and has {len(body)} bytes of them"
    return "" if points and faces else _EMPTY


def _glb(data: bytes) -> str:
    if data[:4] != b"glTF":
        return "it does not begin with 'glTF'"
    length, text = (int.from_bytes(data[k : k + 4], "little") for k in (8, 12))
    if length != len(data):
        return f"it declares {length} bytes and has {len(data)}"
    return _gltf(data[20 : 20 + text])


def _gltf(data: bytes) -> str:
    try:
        return "" if json.loads(data).get("meshes") else _EMPTY
    except (ValueError, AttributeError, RecursionError):
        return "it is no JSON object, the format of glTF"


def _no_point(text: bytes, start: int) -> str:
    return f"{_line(text, start)} is no point of three finite numbers below 1e30"


def _line(text: bytes, start: int) -> str:
    """Return the number of a line and its first characters."""
    line = text[start : start + 60].split(b"\n")[0].strip()
    number = text.count(b"\n", 0, start) + 1
    return f"line {number}, '{legible(line.decode('utf-8', 'replace'))}',"


_CHECKS: Mapping[str, Callable[[bytes], str]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".dae": collada_damage,
    ".ply": _ply,
    ".glb": _glb,
    ".gltf": _gltf,
}

"""Damage of COLLADA meshes (``.dae``)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from xml.parsers import expat

from cbdsl.diagnostics.legible_text import legible
from cbdsl.robot.meshes.decimal import DECIMAL

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

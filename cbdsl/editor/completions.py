"""Names that a value may have, by the keys that enclose it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.lines import lines_of
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import KINDS
from cbdsl.documents.robot import RobotDocument
from cbdsl.editor.buffers import Buffers
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource

#: Keys whose values are names of documents, of the kind with the key's name.
_DOCUMENTS = frozenset({"robot", "stage", "program", "policy", "schema", "calibration"})
_RESOURCES = ("feedback", "effector", "reference")
#: Sections of a program whose values name its controllers.
_COMPOSED = ("actions", "background", "policy", "requires", "rewards", "once", "do")


class Completion(NamedTuple):
    """Name that may be written.

    Attributes:
        name: Name as it is written.
        detail: Short description of it.
    """

    name: str
    detail: str = ""


def choices(buffers: Buffers, path: Path, steps: Sequence[str]) -> list[Completion]:
    """Return the names that a value may have.

    Args:
        buffers: Texts of the editor.
        path: Path of the document.
        steps: Keys that enclose the value.
    """
    key, lines = (steps[-1] if steps else ""), lines_of(buffers.text(path))
    if key == "potential":
        return [
            Completion(each.name, f"{each.symbol}, {each.equation}") for each in POTENTIALS.values()
        ]
    if key == "kind" and len(steps) == 1:
        return [Completion(name, "kind of document") for name in KINDS.usable_names()]
    # At the top level of a program, `policy` is a section with states, and names no document.
    if key in _DOCUMENTS and not (key == "policy" and len(steps) == 1):
        return _documents(buffers, path, key)
    if key in _RESOURCES:
        assignable = [
            Completion(f"${name}", detail)
            for key, detail in (("roles", "role"), ("parameters", "parameter"))
            for name in section(lines, key)
        ]
        return assignable + [_resource(each) for each in robot_resources(buffers, path).values()]
    if is_composed(steps):
        used = [Completion(name, "program") for name in section(lines, "use")]
        return [Completion(name, "controller") for name in section(lines, "controllers")] + used
    return []


# Model of a section: its lines are indented below a key at the first column. Its own keys have the
# indentation of the first one. Text is matched instead of parsed, because a document is seldom
# valid while it is edited. Where this breaks: braces that end on a later line, and braces within
# braces, whose keys may count as keys of the section.
def section(lines: Sequence[str], name: str) -> dict[str, int]:
    """Return the keys of a top-level section with their lines, from 0."""
    keys: dict[str, int] = {}
    inside, indent = False, None
    for number, text in enumerate(lines):
        if re.match(rf"{name}\s*:", text):
            inside = True
            flow = re.search(r"\{(.*)\}", text)
            inline = re.findall(r"(?:^|,)\s*([\w]+)\s*:", flow[1]) if flow else []
            keys.update(dict.fromkeys(inline, number))
        elif inside and re.match(r"\S", text) and not text.startswith("#"):
            break
        elif inside:
            match = re.match(r"(\s+)[\"']?([\w]+)(?:\([\w, ]*\))?[\"']?\s*:", text)
            if match and indent in (None, len(match[1])):
                indent = len(match[1])
                keys[match[2]] = number
    return keys


def robot_resources(buffers: Buffers, path: Path) -> Mapping[str, Resource]:
    """Return the resources of the robot that a document names; empty if that cannot be read."""
    match = re.search(r"^robot:\s*([\w-]+)", buffers.text(path), re.MULTILINE)
    if match is None:
        return {}
    file = buffers.library.find(RobotDocument, match[1], path)
    try:
        return {} if file is None else buffers.resources(file)
    except (DiagnosticsError, UsageError):
        return {}


def _documents(buffers: Buffers, path: Path, kind: str) -> list[Completion]:
    names: Iterable[str] = buffers.library.names(KINDS.get(kind).model, path)
    return [Completion(name, kind) for name in names]


def document_named(buffers: Buffers, path: Path, key: str, name: str) -> Path | None:
    """Return the file of a document that the value of a key names."""
    if key not in _DOCUMENTS:
        return None
    model: type[Document] = KINDS.get(key).model
    return buffers.library.find(model, name, path)


def _resource(resource: Resource) -> Completion:
    return Completion(resource.name, f"{resource.type}, {resource.type.unit}")


def is_composed(steps: Sequence[str]) -> bool:
    """Return whether a place has compositions: an action, a policy's value, or a composite."""
    if not steps:
        return False
    return (
        steps[0] in _COMPOSED
        or steps[-1] in _COMPOSED
        or (steps[0] == "controllers" and len(steps) == 2)
    )

"""The visible robot: links of its URDF, their parents and their shapes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

from cbdsl.reporting.mesh import Mesh, find_mesh, read_mesh

_Numbers = tuple[float, ...]

_GREY = (0.7, 0.7, 0.7)
_KINDS = {"revolute": "turn", "continuous": "turn", "prismatic": "slide"}


class LinkShape(NamedTuple):
    """A visible part of a link.

    Attributes:
        shape: ``ball``, ``box``, ``cylinder`` or ``mesh``.
        size: radius; edge lengths; radius and height along z; for a mesh nothing; m.
        position: in the link's frame, m.
        quaternion: in the link's frame, as (x, y, z, w).
        color: red, green and blue, each from 0 to 1.
        mesh: the triangles of a mesh.
    """

    shape: str
    size: _Numbers
    position: _Numbers
    quaternion: _Numbers
    color: _Numbers
    mesh: Mesh | None = None


class Link(NamedTuple):
    """A link, and the joint that it hangs on.

    Attributes:
        name: of the link.
        parent: index of the link above, -1 for the root, which is at the world's origin.
        position, quaternion: of the joint in the frame of the link above, m and (x, y, z, w).
        motion: ``turn``, ``slide`` or ``fixed``.
        axis: of the joint, in its own frame.
        column: the recorded joint that moves it, -1 for none.
        ratio: angle of this joint per angle of the recorded one.
        offset: angle of this joint where that of the recorded one is 0.
        shapes: what can be seen of the link.
    """

    name: str
    parent: int
    position: _Numbers
    quaternion: _Numbers
    motion: str
    axis: _Numbers
    column: int
    ratio: float
    offset: float
    shapes: tuple[LinkShape, ...]


def read_links(robot: Mapping[str, Any], joints: Sequence[str]) -> list[Link]:
    """The links of a recorded robot, each behind the one that it hangs on.

    Args:
        robot: as the recording has it: ``urdf`` (text), ``folder`` (where meshes are looked for)
            and ``couplings``.
        joints: names of the recorded joints.
    """
    root = ElementTree.fromstring(robot["urdf"])
    colors = {
        material.get("name", ""): color
        for material in root.findall("material")
        if (color := _color(material)) is not None
    }
    elements = {link.get("name", ""): link for link in root.findall("link")}
    above = {_end(joint, "child"): joint for joint in root.findall("joint")}
    links: list[Link] = []
    places: dict[str, int] = {}
    for name in _outwards(elements, above):
        shapes = tuple(_shapes(elements[name], colors, Path(robot["folder"])))
        places[name] = len(links)
        joint = above.get(name)
        if joint is None:
            links.append(Link(name, -1, *_ORIGIN, "fixed", (0, 0, 1), -1, 1.0, 0.0, shapes))
            continue
        column, ratio, offset = _driven(joint, robot["couplings"], joints)
        axis = joint.find("axis")
        links.append(
            Link(
                name,
                places[_end(joint, "parent")],
                *_origin(joint),
                _KINDS.get(joint.get("type", ""), "fixed"),
                (1.0, 0.0, 0.0) if axis is None else _numbers(axis.get("xyz", "1 0 0")),
                column,
                ratio,
                offset,
                shapes,
            )
        )
    return links


def _outwards(
    links: Mapping[str, ElementTree.Element], above: Mapping[str, ElementTree.Element]
) -> Iterator[str]:
    """The links' names, from the root outwards."""
    below: dict[str, list[str]] = {}
    for name, joint in above.items():
        below.setdefault(_end(joint, "parent"), []).append(name)
    waiting = [name for name in links if name not in above]
    while waiting:
        name = waiting.pop(0)
        yield name
        waiting += below.get(name, [])


def _driven(
    joint: ElementTree.Element, couplings: Mapping[str, Any], joints: Sequence[str]
) -> tuple[int, float, float]:
    """The recorded joint that moves a joint, its ratio and its offset."""
    name, mimic = joint.get("name", ""), joint.find("mimic")
    if name in joints:
        return joints.index(name), 1.0, 0.0
    if name in couplings:
        follows, ratio = couplings[name]
        return joints.index(follows), float(ratio), 0.0
    if mimic is not None and mimic.get("joint") in joints:
        ratio, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
        return joints.index(mimic.get("joint", "")), ratio, offset
    return -1, 1.0, 0.0


def _shapes(
    link: ElementTree.Element, colors: Mapping[str, _Numbers], folder: Path
) -> Iterator[LinkShape]:
    for visual in link.findall("visual"):
        geometry, material = visual.find("geometry"), visual.find("material")
        if geometry is None:
            continue
        color: _Numbers = _GREY
        if material is not None:
            color = _color(material) or colors.get(material.get("name", ""), _GREY)
        for element in geometry:
            shape = _shape(element, folder)
            if shape is not None:
                name, size, mesh = shape
                yield LinkShape(name, size, *_origin(visual), color, mesh)


def _shape(element: ElementTree.Element, folder: Path) -> tuple[str, _Numbers, Mesh | None] | None:
    """Kind, size and triangles of a geometry; ``None`` where it cannot be shown."""
    if element.tag == "box":
        return "box", _numbers(element.get("size", "0 0 0")), None
    if element.tag == "sphere":
        return "ball", _numbers(element.get("radius", "0")), None
    if element.tag in ("cylinder", "capsule"):
        size = _numbers(f"{element.get('radius', '0')} {element.get('length', '0')}")
        return "cylinder", size, None
    file = find_mesh(element.get("filename", ""), folder) if element.tag == "mesh" else None
    mesh = None if file is None else read_mesh(file, _numbers(element.get("scale", "1 1 1")))
    return None if mesh is None else ("mesh", (), mesh)


def _color(material: ElementTree.Element) -> _Numbers | None:
    color = material.find("color")
    return None if color is None else _numbers(color.get("rgba", "0.7 0.7 0.7 1"))[:3]


def _end(joint: ElementTree.Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _numbers(text: str) -> _Numbers:
    return tuple(float(word) for word in text.split())


_ORIGIN: tuple[_Numbers, _Numbers] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def _origin(element: ElementTree.Element) -> tuple[_Numbers, _Numbers]:
    """Position and quaternion of the element's ``<origin>``."""
    origin = element.find("origin")
    if origin is None:
        return _ORIGIN
    angles = _numbers(origin.get("rpy", "0 0 0"))
    return _numbers(origin.get("xyz", "0 0 0")), _quaternion(angles)


def _quaternion(rpy: Sequence[float]) -> _Numbers:
    """Turned about the fixed x, then y, then z axis, rad; as (x, y, z, w)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in rpy)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )

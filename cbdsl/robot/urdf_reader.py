"""Reader of URDF models."""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

from cbdsl.robot.robot_xml import (
    refuse_macros,
    require_names_for_engines,
    require_robot,
    robot_text,
    xml_root,
)
from cbdsl.robot.urdf import (
    UNLIMITED,
    Mimic,
    Numbers,
    UrdfError,
    UrdfInertial,
    UrdfJoint,
    UrdfLink,
    UrdfModel,
    UrdfOrigin,
    UrdfShape,
)

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_SPACES = re.compile(r"[ \t\r\n]+")


def read_urdf(path: Path) -> UrdfModel:
    """Read a model without its mesh files.

    Raises:
        UrdfError: If there is no such file, or it is not URDF.
    """
    return parse_urdf(robot_text(path), path)


def read_urdf_if_sound(path: Path) -> UrdfModel | None:
    """Read a model without its mesh files; return ``None`` if it cannot be read."""
    try:
        return read_urdf(path)
    except UrdfError:
        return None


def parse_urdf(text: bytes | str, path: Path) -> UrdfModel:
    """Parse the text of a model.

    Args:
        text: Text of the model.
        path: Path of the model, for messages.

    Raises:
        UrdfError: If it is not URDF.
    """
    root = xml_root(text, path, "URDF")
    refuse_macros(root, path)
    if root.tag == "mujoco":
        raise UrdfError(
            f"{path}: it is MJCF; cb new robot NAME --urdf {path.name} makes URDF of it, with "
            "the extra formats: pip install 'cbdsl[formats]'"
        )
    require_robot(root, path)
    if isinstance(text, bytes):
        require_names_for_engines(root, text, path)
    links = frozenset(link.get("name", "") for link in root.findall("link"))
    try:
        # The order matters: the search for deep chains ends only in a tree, which has no circles.
        _require_few(root)
        _require_distinct(root)
        _require_masses(root)
        joints = [_joint(element, links) for element in root.findall("joint")]
        _require_tree(links, joints)
        _require_shallow(joints)
        joints = _resolved(joints)
    except ValueError as error:
        raise UrdfError(f"{path}: {error}") from None
    return UrdfModel(
        path, links, {joint.name: joint for joint in joints}, _meshes(root),
        tuple(_shapeless(root)), lambda: _links(root, path),
    )  # fmt: skip


def _meshes(root: ElementTree.Element) -> Mapping[str, str]:
    """Return the files of meshes, each with the name of a link that has it."""
    return {
        mesh.get("filename", ""): link.get("name", "")
        for link in root.findall("link")
        for mesh in link.iter("mesh")
    }


def _shapeless(root: ElementTree.Element) -> Iterator[str]:
    """Yield links with mass or visual geometry but no collision geometry."""
    for link in root.findall("link"):
        mass = link.find("inertial/mass")
        text = "0" if mass is None else mass.get("value", "0")
        weighs = _are_numbers(text, 1) and float(text) > 0
        if link.find("collision") is None and (weighs or link.find("visual") is not None):
            yield link.get("name", "")


def _links(root: ElementTree.Element, path: Path) -> list[UrdfLink]:
    """Return all links with their shapes.

    Raises:
        UrdfError: If a value of a link is not a number.
    """
    try:
        colors = {each.get("name", ""): _color(each) for each in root.findall("material")}
        return [_link(element, colors) for element in root.findall("link")]
    except ValueError as error:
        raise UrdfError(f"{path}: {error}") from None


def _require_few(root: ElementTree.Element) -> None:
    """Check that a model has no more parts than any robot.

    Raises:
        ValueError: If it has more.
    """
    for kind, most in _MOST.items():
        count = len(root.findall(kind))
        if count > most:
            raise ValueError(f"it has {count} {kind}s; a model has at most {most}")


def _require_distinct(root: ElementTree.Element) -> None:
    """Require names that are distinct, as all readers of models do.

    Raises:
        ValueError: If an element has no name, or the name of another.
    """
    if not root.get("name"):
        raise ValueError('its <robot> has no name; write <robot name="...">')
    for kind in ("link", "joint", "material"):
        names = [element.get("name", "") for element in root.findall(kind)]
        if "" in names:
            raise ValueError(f"one of its {kind}s has no name")
        twice = next((name for name, count in Counter(names).items() if count > 1), None)
        if twice is not None:
            raise ValueError(f"it has two {kind}s of the name '{twice}'")


def _require_tree(links: frozenset[str], joints: Iterable[UrdfJoint]) -> None:
    """Require one root, from which each link hangs by one joint.

    Raises:
        ValueError: If the joints do not form such a tree.
    """
    movers: dict[str, UrdfJoint] = {}
    for joint in joints:
        other = movers.setdefault(joint.child, joint)
        if other is not joint:
            raise ValueError(
                f"its link '{joint.child}' is moved by two joints, '{other.name}' and "
                f"'{joint.name}'; a model is a tree, so remove one of them"
            )
    roots = sorted(links - movers.keys())
    if not links:
        raise ValueError("it has no <link>")
    if not roots:
        raise ValueError("its joints go in a circle: every link is moved by another")
    if len(roots) > 1:
        names = " and ".join(f"'{name}'" for name in roots[:3])
        raise ValueError(f"its links {names} are not joined; a model is one tree with one root")
    _require_no_circle(movers, roots[0])


def _require_no_circle(movers: Mapping[str, UrdfJoint], root: str) -> None:
    """Require that the path from each link upwards ends at the root.

    Raises:
        ValueError: If some links carry one another.
    """
    # One root does not exclude a separate ring, such as two links that carry each other. Each link
    # is passed once, because the search stops at links that are known to hang from the root.
    hanging = {root}
    for link in movers:
        way: dict[str, None] = {}
        while link not in hanging:
            if link in way:
                circle = [*way][[*way].index(link) :]
                names = " and ".join(f"'{name}'" for name in circle[:3])
                raise ValueError(f"its joints go in a circle: links {names} carry one another")
            way[link] = None
            link = movers[link].parent
        hanging.update(way)


def _resolved(joints: Sequence[UrdfJoint]) -> list[UrdfJoint]:
    """Return the joints with their chains of mimics resolved.

    Raises:
        ValueError: If a joint mimics itself, directly or through others.
    """
    mimics = {joint.name: joint.mimic for joint in joints}
    for name in mimics:
        _resolve(name, mimics)
    movable = {joint.name for joint in joints if joint.movable}
    return [
        joint._replace(mimic=mimic, leaderless=mimic is not None and mimic.joint not in movable)
        for joint, mimic in zip(joints, mimics.values(), strict=True)
    ]


def _resolve(name: str, mimics: dict[str, Mimic | None]) -> None:
    """Replace the mimics along a joint's chain by mimics of the last joint in it."""
    chain: dict[str, Mimic] = {}
    while (mimic := mimics.get(name)) is not None:
        if name in chain:
            others = [*chain][[*chain].index(name) + 1 :]
            by_way = f", by way of '{others[0]}'" if others else ""
            raise ValueError(f"joint '{name}' mimics itself{by_way}; remove a <mimic>")
        chain[name] = mimic
        name = mimic.joint
    # With q1 = r1 q2 + o1 and q2 = r2 q3 + o2, q1 = r1 r2 q3 + (r1 o2 + o1). The chain is folded
    # from its leader backwards, so that each follower uses the already resolved joint that it
    # follows.
    master = Mimic(name, 1.0, 0.0)
    for follower, own in reversed(chain.items()):
        ratio, offset = own.ratio * master.ratio, own.ratio * master.offset + own.offset
        mimics[follower] = master = Mimic(name, ratio, offset)


def _require_shallow(joints: Iterable[UrdfJoint]) -> None:
    """Check that no link is further from the root than in any robot.

    Raises:
        ValueError: If one is.
    """
    # The depths are found by a loop, because recursion would fail on the very models that this
    # refuses.
    parents = {joint.child: joint.parent for joint in joints}
    depths: dict[str, int] = {}
    for link in parents:
        way = []
        while link in parents and link not in depths:
            way.append(link)
            link = parents[link]
        depth = depths.get(link, 0)
        for passed in reversed(way):
            depth += 1
            depths[passed] = depth
    if depths and max(depths.values()) > _DEEPEST:
        raise ValueError(f"it has a chain of more than {_DEEPEST} joints")


def _joint(element: ElementTree.Element, links: frozenset[str]) -> UrdfJoint:
    name, kind = element.get("name", ""), element.get("type", "")
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        raise ValueError(f"joint '{name}' has no parent or no child")
    for end in (parent, child):
        if end.get("link") not in links:
            raise ValueError(f"joint '{name}' joins link '{end.get('link')}', which is not there")
    limit = element.find("limit")
    problem = _problem(kind, limit) or next(_not_numbers(element), None)
    axis = element.find("axis")
    if problem is not None:
        raise ValueError(f"joint '{name}' {problem}")
    # A continuous joint may have a <limit>, but only of its effort and velocity. Elsewhere, a
    # missing lower or upper limit is 0 by the specification of URDF.
    bounded = limit is not None and kind != "continuous"
    lower, upper = (_limit(limit, "lower"), _limit(limit, "upper")) if bounded else (None, None)
    return UrdfJoint(
        name=name,
        parent=parent.get("link", ""),
        child=child.get("link", ""),
        kind=kind,
        lower=-math.inf if lower is None or lower <= -UNLIMITED else lower,
        upper=math.inf if upper is None or upper >= UNLIMITED else upper,
        limited=limit is not None and not {"lower", "upper"}.isdisjoint(limit.keys()),
        mimic=_mimic(element.find("mimic")),
        origin=_origin(element),
        axis=(1.0, 0.0, 0.0) if axis is None else _numbers(axis.get("xyz", "1 0 0")),
        velocity=_most(limit, "velocity"),
        effort=_most(limit, "effort"),
        zero_effort=_limit(limit, "effort") == 0,
    )


# Models of humanoids with all fingers have 100 links; those of cables a few hundred in series.
_MOST = {"link": 10_000, "joint": 10_000, "material": 10_000, "transmission": 10_000}
_DEEPEST = 1_000
_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_EXAMPLE = '<limit lower="-1.57" upper="1.57" effort="10" velocity="2"/>'


def _problem(kind: str, limit: ElementTree.Element | None) -> str | None:
    """Return the reason why kinematics and simulators would refuse a joint, or ``None``."""
    if kind not in _KINDS:
        return f"has the type '{kind}', which is none of {', '.join(_KINDS)}"
    if limit is None:
        needs_one = kind in ("revolute", "prismatic")
        return f"is {kind} and has no <limit>, such as {_EXAMPLE}" if needs_one else None
    for key in ("effort", "velocity"):
        if limit.get(key) is None:
            return f"has a <limit> without {key}; write it as in {_EXAMPLE}"
        if limit.get(key, "").lstrip().startswith("-"):
            return f"has the {key} limit {limit.get(key)}; limits are 0, for none, or more"
    return None


def _require_masses(root: ElementTree.Element) -> None:
    """Check that no link has a negative mass.

    Raises:
        ValueError: If one has.
    """
    for link in root.findall("link"):
        mass = link.find("inertial/mass")
        text = "0" if mass is None else mass.get("value", "0")
        if text.lstrip().startswith("-"):
            raise ValueError(f"link '{link.get('name')}' has the mass {text}, which is below 0")


_COUNTS = {"xyz": 3, "rpy": 3, "lower": 1, "upper": 1, "effort": 1, "velocity": 1}
_COUNTS |= {"multiplier": 1, "offset": 1, "damping": 1, "friction": 1}
_COUNTS |= {"size": 3, "radius": 1, "length": 1, "scale": 3, "value": 1}
_COUNTS |= {"ixx": 1, "iyy": 1, "izz": 1, "ixy": 1, "ixz": 1, "iyz": 1}


def _not_numbers(element: ElementTree.Element) -> Iterator[str]:
    """Yield the invalid attributes of a joint or link that should be one or three numbers."""
    for inner in element.iter():
        for key, text in inner.items():
            count = _COUNTS.get(key)
            if key == "value" and inner.tag != "mass":
                continue  # part of an extension, which may be any word
            if key == "scale" and _are_numbers(text, 4):
                continue  # a public model has the fourth homogeneous coordinate, too
            if count is not None and not _are_numbers(text, count):
                wanted = "a number" if count == 1 else "three numbers with spaces between them"
                yield f'has {key}="{text}", which should be {wanted}'


def _are_numbers(text: str, count: int) -> bool:
    """Return whether a text is so many finite numbers in a form that all engines read.

    Python alone reads digits of other scripts, underscores and unusual spaces; engines stop there.
    """
    words = [word for word in _SPACES.split(text) if word]
    return len(words) == count and all(
        _NUMBER.fullmatch(word) and math.isfinite(float(word)) for word in words
    )


def _numbers(text: str) -> Numbers:
    return tuple(map(float, text.split()))


def _origin(element: ElementTree.Element) -> UrdfOrigin:
    """Return the ``<origin>`` of an element; without one, no displacement."""
    origin = element.find("origin")
    if origin is None:
        return UrdfOrigin()
    return UrdfOrigin(_numbers(origin.get("xyz", "0 0 0")), _numbers(origin.get("rpy", "0 0 0")))


def _color(material: ElementTree.Element) -> Numbers | None:
    color = material.find("color")
    if color is None:
        return None
    text = color.get("rgba", "0.7 0.7 0.7 1")
    if not (_are_numbers(text, 4) or _are_numbers(text, 3)):
        name = material.get("name", "")
        raise ValueError(f"material '{name}' has rgba=\"{text}\", which should be four numbers")
    return _numbers(text)[:3]


def _link(element: ElementTree.Element, colors: Mapping[str, Numbers | None]) -> UrdfLink:
    name = element.get("name", "")
    problem = next(_not_numbers(element), None)
    if problem is not None:
        raise ValueError(f"link '{name}' {problem}")
    visuals, collisions = (
        tuple(_shapes(element.findall(use), colors)) for use in ("visual", "collision")
    )
    return UrdfLink(name, visuals, collisions, _inertial(element.find("inertial")))


def _shapes(
    elements: Iterable[ElementTree.Element], colors: Mapping[str, Numbers | None]
) -> Iterator[UrdfShape]:
    for element in elements:
        material, color = element.find("material"), None
        if material is not None:
            color = _color(material) or colors.get(material.get("name", ""))
        for geometry in element.findall("geometry/*"):
            file = geometry.get("filename", "")
            if geometry.tag in _SIZES:
                kind, keys = _SIZES[geometry.tag]
                size = " ".join(geometry.get(key, unsaid) for key, unsaid in keys.items())
                yield UrdfShape(kind, _numbers(size)[:3], _origin(element), color, file)


_SIZES = {
    "sphere": ("ball", {"radius": "0"}),
    "box": ("box", {"size": "0 0 0"}),
    "cylinder": ("cylinder", {"radius": "0", "length": "0"}),
    "capsule": ("capsule", {"radius": "0", "length": "0"}),
    "mesh": ("mesh", {"scale": "1 1 1"}),
}


def _inertial(element: ElementTree.Element | None) -> UrdfInertial | None:
    if element is None:
        return None
    mass, inertia = element.find("mass"), element.find("inertia")
    moments = {} if inertia is None else inertia.attrib
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    return UrdfInertial(
        0.0 if mass is None else float(mass.get("value", "0")),
        tuple(float(moments.get(key, "0")) for key in keys),
        _origin(element),
    )


def _mimic(element: ElementTree.Element | None) -> Mimic | None:
    if element is None:
        return None
    ratio, offset = element.get("multiplier", "1"), element.get("offset", "0")
    return Mimic(element.get("joint", ""), float(ratio), float(offset))


def _limit(limit: ElementTree.Element | None, key: str) -> float | None:
    return None if limit is None else float(limit.get(key, "0"))


def _most(limit: ElementTree.Element | None, key: str) -> float:
    """Return a limit of velocity or effort, infinite if it is missing or 0."""
    return (_limit(limit, key) or math.inf) if limit is not None else math.inf

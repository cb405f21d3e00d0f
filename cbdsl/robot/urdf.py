"""What the checker needs of a URDF model: its links, its joints and their limits."""

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree


class UrdfError(ValueError):
    """A URDF model cannot be read; the message says why."""


class Mimic(NamedTuple):
    """What a passive joint follows: ``ratio`` times the position of another, plus ``offset``."""

    joint: str
    ratio: float
    offset: float


class UrdfJoint(NamedTuple):
    """A joint of the model; limits in rad, or m where it slides.

    ``length`` is the distance between the frames of its two links, m, unless it slides.

    Only ``revolute`` joints can be moved: they turn, and between limits.
    """

    name: str
    parent: str
    child: str
    kind: str
    lower: float
    upper: float
    limited: bool
    mimic: Mimic | None = None
    length: float = 0.0

    @property
    def revolute(self) -> bool:
        """Whether it turns between limits."""
        return self.kind == "revolute"

    @property
    def fixed(self) -> bool:
        """Whether it only holds two links together."""
        return self.kind == "fixed"


class UrdfModel(NamedTuple):
    """The tree of links and joints.

    Attributes:
        path: its file.
        links: names of all links.
        joints: all joints by name.
        turning: by link, the names of the revolute joints above it, from the link upwards.
    """

    path: Path
    links: frozenset[str]
    joints: Mapping[str, UrdfJoint]
    turning: Mapping[str, tuple[str, ...]]

    @property
    def revolute(self) -> tuple[str, ...]:
        """Names of the joints that turn between limits, in the file's order."""
        return tuple(joint.name for joint in self.joints.values() if joint.revolute)

    def above(self, link: str) -> tuple[str, ...]:
        """Names of the revolute joints between a link and the root, from the link upwards."""
        return self.turning.get(link, ())

    def reach(self, base: str, link: str) -> float | None:
        """A bound on the distance of a link's frame from another's, m, wherever joints turn.

        Returns:
            ``None`` where something between them slides, so that there is no such bound.
        """
        between = set(self._way(base)).symmetric_difference(self._way(link))
        turn = all(joint.kind in ("fixed", "revolute", "continuous") for joint in between)
        return sum(joint.length for joint in between) if turn else None

    def _way(self, link: str) -> tuple[UrdfJoint, ...]:
        return _way(link, {joint.child: joint for joint in self.joints.values()})


def _way(link: str, parents: Mapping[str, UrdfJoint]) -> tuple[UrdfJoint, ...]:
    """All joints between a link and the root; each of the parents is by the link that it moves."""
    way: list[UrdfJoint] = []
    while link in parents and len(way) < len(parents):  # which ends where there is a loop
        way.append(parents[link])
        link = way[-1].parent
    return tuple(way)


def read_urdf(path: Path) -> UrdfModel:
    """Read a model's structure; masses, shapes and meshes are left to the simulator.

    Raises:
        UrdfError: there is no such file, or it is no URDF.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except OSError as error:
        raise UrdfError(f"{path}: {error.strerror}") from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise UrdfError(f"{path}: it is no XML, of which URDF is made: {error}") from None
    if any("xacro" in element.tag for element in root.iter()):
        raise UrdfError(f"{path}: it is xacro; `xacro {path.name} > {path.stem}.urdf` expands it")
    if root.tag != "robot":
        raise UrdfError(f"{path}: its root is <{root.tag}>, not <robot>")
    links = frozenset(link.get("name", "") for link in root.findall("link"))
    try:
        _require_distinct(root)
        joints = [_joint(element, links) for element in root.findall("joint")]
        _require_tree(links, joints)
    except ValueError as error:
        raise UrdfError(f"{path}: {error}") from None
    parents = {joint.child: joint for joint in joints}
    ways = {link: _way(link, parents) for link in links}
    turning = {link: tuple(j.name for j in way if j.revolute) for link, way in ways.items()}
    return UrdfModel(path, links, {joint.name: joint for joint in joints}, turning)


def _require_distinct(root: ElementTree.Element) -> None:
    """Whatever reads models insists on names, and on different ones.

    Raises:
        ValueError: something has no name, or that of another.
    """
    if not root.get("name"):
        raise ValueError('its <robot> has no name; write <robot name="...">')
    for kind in ("link", "joint"):
        names = [element.get("name", "") for element in root.findall(kind)]
        if "" in names:
            raise ValueError(f"one of its {kind}s has no name")
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"it has two {kind}s of the name '{twice}'")


def _require_tree(links: frozenset[str], joints: Iterable[UrdfJoint]) -> None:
    """A model has one root.

    Raises:
        ValueError: it has none, or several.
    """
    roots = sorted(links - {joint.child for joint in joints})
    if not links:
        raise ValueError("it has no <link>")
    if not roots:
        raise ValueError("its joints go in a circle: every link is moved by another")
    if len(roots) > 1:
        names = " and ".join(f"'{name}'" for name in roots[:3])
        raise ValueError(f"its links {names} are not joined; a model is one tree with one root")


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
    if problem is not None:
        raise ValueError(f"joint '{name}' {problem}")
    bounded = limit is not None and kind != "continuous"
    lower, upper = (_limit(limit, "lower"), _limit(limit, "upper")) if bounded else (None, None)
    return UrdfJoint(
        name=name,
        parent=parent.get("link", ""),
        child=child.get("link", ""),
        kind=kind,
        lower=-math.inf if lower is None else lower,
        upper=math.inf if upper is None else upper,
        limited=limit is not None and not {"lower", "upper"}.isdisjoint(limit.keys()),
        mimic=_mimic(element.find("mimic")),
        length=_length(element.find("origin")),
    )


_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_EXAMPLE = '<limit lower="-1.57" upper="1.57" effort="10" velocity="2"/>'


def _problem(kind: str, limit: ElementTree.Element | None) -> str | None:
    """Why kinematics and simulators would refuse a joint, and with it the model."""
    if kind not in _KINDS:
        return f"has the type '{kind}', which is none of {', '.join(_KINDS)}"
    if limit is None:
        needs_one = kind in ("revolute", "prismatic")
        return f"is {kind} and has no <limit>, such as {_EXAMPLE}" if needs_one else None
    for key in ("effort", "velocity"):
        if limit.get(key) is None:
            return f"has a <limit> without {key}; write it as in {_EXAMPLE}"
    return None


_COUNTS = {"xyz": 3, "rpy": 3, "lower": 1, "upper": 1, "effort": 1, "velocity": 1}
_COUNTS |= {"multiplier": 1, "offset": 1, "damping": 1, "friction": 1}


def _not_numbers(element: ElementTree.Element) -> Iterator[str]:
    """What a joint has where one or three numbers should be."""
    for inner in element:
        for key, text in inner.items():
            count = _COUNTS.get(key)
            if count is not None and not _are_numbers(text, count):
                wanted = "a number" if count == 1 else "three numbers with spaces between them"
                yield f'has {key}="{text}", which should be {wanted}'


def _are_numbers(text: str, count: int) -> bool:
    try:
        return len([x for x in map(float, text.split()) if math.isfinite(x)]) == count
    except ValueError:
        return False


def _length(origin: ElementTree.Element | None) -> float:
    """The length of a joint's offset from its parent; numbers are read before."""
    return 0.0 if origin is None else math.hypot(*map(float, origin.get("xyz", "0 0 0").split()))


def _mimic(element: ElementTree.Element | None) -> Mimic | None:
    if element is None:
        return None
    ratio, offset = element.get("multiplier", "1"), element.get("offset", "0")
    return Mimic(element.get("joint", ""), float(ratio), float(offset))


def _limit(limit: ElementTree.Element | None, key: str) -> float | None:
    return None if limit is None else float(limit.get(key, "0"))

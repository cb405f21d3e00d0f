"""What the checker needs of a URDF model: its links, its joints and their limits."""

import math
from collections.abc import Iterator, Mapping
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

    Only ``revolute`` joints can be moved: they turn, and between limits.
    """

    name: str
    parent: str
    child: str
    revolute: bool
    lower: float
    upper: float
    fixed: bool = False
    mimic: Mimic | None = None


class UrdfModel(NamedTuple):
    """The tree of links and joints.

    Attributes:
        path: its file.
        links: names of all links.
        joints: all joints by name.
    """

    path: Path
    links: frozenset[str]
    joints: Mapping[str, UrdfJoint]

    @property
    def revolute(self) -> tuple[str, ...]:
        """Names of the joints that can be moved, in the file's order."""
        return tuple(joint.name for joint in self.joints.values() if joint.revolute)

    def above(self, link: str) -> Iterator[str]:
        """Names of the revolute joints between a link and the root, from the link upwards."""
        parents = {joint.child: joint for joint in self.joints.values()}
        for _ in range(len(parents)):  # bounds the walk where the model has a loop
            joint = parents.get(link)
            if joint is None:
                return
            if joint.revolute:
                yield joint.name
            link = joint.parent


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
        raise UrdfError(f"{path}: {error}") from None
    if root.tag != "robot":
        raise UrdfError(f"{path}: its root is <{root.tag}>, not <robot>")
    links = frozenset(link.get("name", "") for link in root.findall("link"))
    try:
        joints = [_joint(element, links) for element in root.findall("joint")]
    except ValueError as error:
        raise UrdfError(f"{path}: {error}") from None
    return UrdfModel(path, links, {joint.name: joint for joint in joints})


def _joint(element: ElementTree.Element, links: frozenset[str]) -> UrdfJoint:
    name, kind = element.get("name", ""), element.get("type", "")
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        raise ValueError(f"joint '{name}' has no parent or no child")
    for end in (parent, child):
        if end.get("link") not in links:
            raise ValueError(f"joint '{name}' joins link '{end.get('link')}', which is not there")
    limit = element.find("limit")
    if kind == "revolute" and limit is None:
        raise ValueError(f"joint '{name}' is revolute and has no <limit>")
    bounded = limit is not None and kind != "continuous"
    lower, upper = (_limit(limit, "lower"), _limit(limit, "upper")) if bounded else (None, None)
    return UrdfJoint(
        name=name,
        parent=parent.get("link", ""),
        child=child.get("link", ""),
        revolute=kind == "revolute",
        lower=-math.inf if lower is None else lower,
        upper=math.inf if upper is None else upper,
        fixed=kind == "fixed",
        mimic=_mimic(element.find("mimic")),
    )


def _mimic(element: ElementTree.Element | None) -> Mimic | None:
    if element is None:
        return None
    ratio, offset = element.get("multiplier", "1"), element.get("offset", "0")
    return Mimic(element.get("joint", ""), float(ratio), float(offset))


def _limit(limit: ElementTree.Element | None, key: str) -> float | None:
    return None if limit is None else float(limit.get(key, "0"))

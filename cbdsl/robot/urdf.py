"""URDF models: links, joints, limits and shapes."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

Numbers = tuple[float, ...]
Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]


#: Limits at least this far from 0, rad or m, mean none: exporters write them for want of infinity.
UNLIMITED = 1e6


class UrdfError(ValueError):
    """A URDF model cannot be read; the message says why."""


class UrdfOrigin(NamedTuple):
    """A frame in another one.

    Attributes:
        xyz: position, m.
        rpy: turns about the fixed x, then y, then z axis, rad.
    """

    xyz: Numbers = (0.0, 0.0, 0.0)
    rpy: Numbers = (0.0, 0.0, 0.0)

    @property
    def quaternion(self) -> Numbers:
        """The rotation, as (x, y, z, w)."""
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in self.rpy)
        return (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )

    @property
    def rotation(self) -> Rotation:
        """The rotation, as three rows of a matrix."""
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in self.rpy)
        return (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )


class UrdfShape(NamedTuple):
    """A visible or colliding part of a link.

    Attributes:
        kind: ``ball``, ``box``, ``cylinder``, ``capsule`` or ``mesh``.
        size: radius; edge lengths; radius and height along z; for a mesh its scale; m.
        origin: in the link's frame.
        color: red, green and blue, each from 0 to 1, if the model gives one.
        file: of a mesh, as the model names it.
    """

    kind: str
    size: Numbers
    origin: UrdfOrigin
    color: Numbers | None = None
    file: str = ""


class UrdfInertial(NamedTuple):
    """Mass, kg, and inertia (xx, yy, zz, xy, xz, yz), kg m^2, about the centre of mass."""

    mass: float
    inertia: Numbers
    origin: UrdfOrigin


class UrdfLink(NamedTuple):
    """A rigid body of the model."""

    name: str
    visuals: tuple[UrdfShape, ...]
    collisions: tuple[UrdfShape, ...]
    inertial: UrdfInertial | None


class Mimic(NamedTuple):
    """Coupling of a passive joint: ``ratio`` times another's position, plus ``offset``.

    The other joint mimics none itself: the reader resolves chains. It may be missing.
    """

    joint: str
    ratio: float
    offset: float


class UrdfJoint(NamedTuple):
    """A joint of the model; positions in rad, or m where it is prismatic.

    Attributes:
        name: of the joint.
        parent, child: the links that it joins.
        kind: the URDF's type.
        lower, upper: limits; infinite without them, where the joint is continuous, and from
            ``UNLIMITED`` on.
        limited: whether the model states limits of its position.
        mimic: the joint that it follows, if any.
        origin: its frame at zero in the frame of its parent.
        axis: along or about which it moves, in its own frame.
        velocity, effort: largest rate, rad/s or m/s, and torque or force, N m or N; infinite
            without a limit, or with one of 0, which most models mean by it.
        zero_effort: whether the model says 0 for the effort.
        leaderless: whether the joint that it mimics is missing, or does not move.
    """

    name: str
    parent: str
    child: str
    kind: str
    lower: float
    upper: float
    limited: bool
    mimic: Mimic | None = None
    origin: UrdfOrigin = UrdfOrigin()
    axis: Numbers = (1.0, 0.0, 0.0)
    velocity: float = math.inf
    effort: float = math.inf
    zero_effort: bool = False
    leaderless: bool = False

    @property
    def movable(self) -> bool:
        """Whether it turns about, or slides along, one axis."""
        return self.kind in ("revolute", "continuous", "prismatic")

    @property
    def slides(self) -> bool:
        """Whether its position is a length, m, and no angle."""
        return self.kind == "prismatic"

    @property
    def endless(self) -> bool:
        """Whether it turns without limits."""
        return self.kind == "continuous" or (
            self.kind == "revolute" and self.lower == -math.inf and self.upper == math.inf
        )

    @property
    def rest(self) -> float:
        """The position nearest to 0 within the limits, rad or m."""
        return min(max(0.0, self.lower), self.upper) if self.lower <= self.upper else 0.0

    @property
    def fixed(self) -> bool:
        """Whether it only holds two links together."""
        return self.kind == "fixed"

    @property
    def directed(self) -> bool:
        """Whether it moves along or about an axis that has a direction, if it moves."""
        return self.fixed or any(self.axis)

    @property
    def length(self) -> float:
        """Largest distance between the frames of its two links, m; infinite without limits."""
        slide = max(abs(self.lower), abs(self.upper)) if self.slides else 0.0
        return math.hypot(*self.origin.xyz) + slide


@dataclass(frozen=True, eq=False)
class UrdfModel:
    """The tree of links and joints.

    Attributes:
        path: its file.
        links: names of all links.
        joints: all joints by name.
        meshes: their files as the model names them, each with a link that it is a part of.
        shapeless: names of the links that are visible or weigh something, and have no collision
            geometry.
    """

    path: Path
    links: frozenset[str]
    joints: Mapping[str, UrdfJoint]
    meshes: Mapping[str, str]
    shapeless: tuple[str, ...]
    _read_links: Callable[[], Iterable[UrdfLink]] = field(repr=False)

    @cached_property
    def bodies(self) -> Mapping[str, UrdfLink]:
        """All links by name, read when they are first asked for.

        Raises:
            UrdfError: a link has something else where numbers should be.
        """
        return {body.name: body for body in self._read_links()}

    @property
    def movable(self) -> tuple[str, ...]:
        """Names of the joints that turn about or slide along one axis, in the file's order."""
        return tuple(joint.name for joint in self.joints.values() if joint.movable)

    @cached_property
    def rests(self) -> Mapping[str, float]:
        """Positions of the movable joints where nothing drives them, by name, rad or m.

        They are as near to 0 as the limits allow; a joint that mimics another follows it there.
        """
        return {joint.name: self._rest(joint) for joint in self.joints.values() if joint.movable}

    def _rest(self, joint: UrdfJoint) -> float:
        mimic = joint.mimic
        if mimic is None or mimic.joint not in self.joints or joint.lower > joint.upper:
            return joint.rest
        followed = mimic.ratio * self.joints[mimic.joint].rest + mimic.offset
        return min(max(followed, joint.lower), joint.upper)

    def above(self, link: str) -> tuple[str, ...]:
        """Names of the movable joints between a link and the root, from the link upwards."""
        if link not in self._moving:
            self._moving[link] = tuple(joint.name for joint in self.way(link) if joint.movable)
        return self._moving[link]

    def reach(self, base: str, link: str) -> float | None:
        """A bound on the distance of a link's frame from another's, m, wherever joints are.

        Returns:
            ``None`` where something between them slides without limits, floats or moves in a plane.
        """
        between = set(self.way(base)).symmetric_difference(self.way(link))
        bounded = all(joint.fixed or joint.movable for joint in between)
        reach = sum(joint.length for joint in between)
        return reach if bounded and math.isfinite(reach) else None

    def way(self, link: str) -> tuple[UrdfJoint, ...]:
        """All joints between a link and the root, from the link upwards."""
        return way_to_root(link, self._parents)

    @cached_property
    def _moving(self) -> dict[str, tuple[str, ...]]:
        """Names of movable joints above links that were asked for."""
        return {}

    @cached_property
    def _parents(self) -> Mapping[str, UrdfJoint]:
        """Joints by the link that they move."""
        return {joint.child: joint for joint in self.joints.values()}


def way_to_root(link: str, parents: Mapping[str, UrdfJoint]) -> tuple[UrdfJoint, ...]:
    """All joints between a link and the root; each of the parents is by the link that it moves."""
    way: list[UrdfJoint] = []
    while link in parents and len(way) < len(parents):  # which ends where there is a loop
        way.append(parents[link])
        link = way[-1].parent
    return tuple(way)

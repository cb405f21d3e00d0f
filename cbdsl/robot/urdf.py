"""URDF models: links, joints, limits and shapes."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

Numbers = tuple[float, ...]
Vector = tuple[float, float, float]
Rotation = tuple[Vector, Vector, Vector]


#: Limits at least this far from 0, rad or m, count as infinite; exporters write such numbers.
UNLIMITED = 1e6


class UrdfError(ValueError):
    """Unreadable URDF model; the message says why."""


class UrdfOrigin(NamedTuple):
    """Frame in another one.

    Attributes:
        xyz: Position, m.
        rpy: Turns about the fixed x, then y, then z axis, rad.
    """

    xyz: Numbers = (0.0, 0.0, 0.0)
    rpy: Numbers = (0.0, 0.0, 0.0)

    @property
    def quaternion(self) -> Numbers:
        """Rotation as (x, y, z, w)."""
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in self.rpy)
        return (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )

    @property
    def rotation(self) -> Rotation:
        """Rotation as three rows of a matrix."""
        # R = Rz(yaw) Ry(pitch) Rx(roll), with turns about the fixed axes of the parent.
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in self.rpy)
        return (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )


class UrdfShape(NamedTuple):
    """Visual or collision geometry of a link.

    Attributes:
        kind: Kind: ``ball``, ``box``, ``cylinder``, ``capsule`` or ``mesh``.
        size: Radius; edge lengths; radius and height along z; for a mesh its scale; m.
        origin: Frame in the link's frame.
        color: Red, green and blue, each from 0 to 1, if the model gives one.
        file: Path of a mesh, as the model names it.
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
    """Rigid body of the model."""

    name: str
    visuals: tuple[UrdfShape, ...]
    collisions: tuple[UrdfShape, ...]
    inertial: UrdfInertial | None


class Mimic(NamedTuple):
    """Coupling of a passive joint: ``ratio`` times another's position, plus ``offset``.

    The other joint does not mimic a third one, because the reader resolves chains. It may be
    missing.
    """

    joint: str
    ratio: float
    offset: float


class UrdfJoint(NamedTuple):
    """Joint of the model; positions in rad, or in m if it is prismatic.

    Attributes:
        name: Name of the joint.
        parent, child: Links that it connects.
        kind: Type in the URDF.
        lower, upper: Limits; infinite if there are none, if the joint is continuous, and from
            ``UNLIMITED`` on.
        limited: True if the model states limits of its position.
        mimic: Coupling to another joint, if any.
        origin: Frame at zero in the frame of its parent.
        axis: Axis of its motion, in its own frame.
        velocity, effort: Largest rate, rad/s or m/s, and torque or force, N m or N; infinite
            without a limit or with a limit of 0, which means unlimited in most models.
        zero_effort: True if the model states an effort of 0.
        leaderless: True if the joint that it mimics is missing, or does not move.
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
        """Whether its position is a length, m, instead of an angle."""
        return self.kind == "prismatic"

    @property
    def unit(self) -> str:
        """SI unit of its position."""
        return "m" if self.slides else "rad"

    @property
    def endless(self) -> bool:
        """Whether it turns without limits."""
        return self.kind == "continuous" or (
            self.kind == "revolute" and self.lower == -math.inf and self.upper == math.inf
        )

    @property
    def rest(self) -> float:
        """Position nearest to 0 within the limits, rad or m."""
        return min(max(0.0, self.lower), self.upper) if self.lower <= self.upper else 0.0

    @property
    def fixed(self) -> bool:
        """Whether it connects two links rigidly."""
        return self.kind == "fixed"

    @property
    def directed(self) -> bool:
        """Whether its axis of motion has a direction, if it moves."""
        return self.fixed or any(self.axis)

    @property
    def length(self) -> float:
        """Largest distance between the frames of its two links, m; infinite without limits."""
        slide = max(abs(self.lower), abs(self.upper)) if self.slides else 0.0
        return math.hypot(*self.origin.xyz) + slide


@dataclass(frozen=True, eq=False)
class UrdfModel:
    """Tree of links and joints.

    Attributes:
        path: Path of the file.
        links: Names of all links.
        joints: All joints by name.
        meshes: Files of meshes as the model names them, each with a link that has it.
        shapeless: Names of the links with visual geometry or mass, but no collision geometry.
    """

    path: Path
    links: frozenset[str]
    joints: Mapping[str, UrdfJoint]
    meshes: Mapping[str, str]
    shapeless: tuple[str, ...]
    _read_links: Callable[[], Iterable[UrdfLink]] = field(repr=False)

    @cached_property
    def bodies(self) -> Mapping[str, UrdfLink]:
        """All links by name, read on first access.

        Raises:
            UrdfError: If a value of a link is not a number.
        """
        return {body.name: body for body in self._read_links()}

    @property
    def movable(self) -> tuple[str, ...]:
        """Names of the joints that turn about or slide along one axis, in the file's order."""
        return tuple(joint.name for joint in self.joints.values() if joint.movable)

    @cached_property
    def rests(self) -> Mapping[str, float]:
        """Positions of the movable joints at rest, by name, rad or m.

        They are as near to 0 as the limits allow; a mimicking joint follows the other one.
        """
        return {joint.name: self._rest(joint) for joint in self.joints.values() if joint.movable}

    def _rest(self, joint: UrdfJoint) -> float:
        mimic = joint.mimic
        # A follower without its leader, or with limits in the wrong order, rests by itself.
        if mimic is None or mimic.joint not in self.joints or joint.lower > joint.upper:
            return joint.rest
        followed = mimic.ratio * self.joints[mimic.joint].rest + mimic.offset
        return min(max(followed, joint.lower), joint.upper)

    def above(self, link: str) -> tuple[str, ...]:
        """Return the names of the movable joints from a link up to the root."""
        if link not in self._moving:
            self._moving[link] = tuple(joint.name for joint in self.way(link) if joint.movable)
        return self._moving[link]

    def reach(self, base: str, link: str) -> float | None:
        """Return a bound on the distance between the frames of two links, m, for all postures.

        Returns:
            Bound, or ``None`` if a joint between them slides without limits, floats or moves in a
            plane.
        """
        # By the triangle inequality, the distance is at most the sum of the distances between
        # successive frames on the way between the links. A turn does not change the distance
        # between its own two frames, and a slide adds its stroke. Joints on both ways to the root
        # cancel, because they move both links alike.
        between = set(self.way(base)).symmetric_difference(self.way(link))
        bounded = all(joint.fixed or joint.movable for joint in between)
        reach = sum(joint.length for joint in between)
        return reach if bounded and math.isfinite(reach) else None

    def beyond(self, link: str) -> Iterator[UrdfJoint]:
        """Yield all joints beyond a link, each after its parent joint."""
        waiting = self._branches.get(link, [])[::-1]
        while waiting:
            joint = waiting.pop()
            yield joint
            waiting += self._branches.get(joint.child, [])[::-1]

    @property
    def roots(self) -> list[str]:
        """Names of the links that no joint moves, sorted."""
        return sorted(self.links - self._parents.keys())

    def carried_pairs(self) -> frozenset[tuple[str, str]]:
        """Return the pairs of links whose contacts count for nothing, each in order of the names.

        One carries the other, or is fixed to a moving link that does, or both are fixed to one
        moving link. Shapes of neighbours overlap at their joints, as hulls of meshes do. Contacts
        with links fixed to the root, such as a pedestal, count.
        """
        fixed: dict[tuple[str, ...], list[str]] = {}
        for link in self.links:
            fixed.setdefault(self.above(link), []).append(link)
        pairs = set[tuple[str, str]]()
        for link in self.links:
            way = self.above(link)
            carriers = {joint.parent for joint in self.way(link)}.union(
                *(fixed.get(way[i:], ()) for i in range(len(way)))
            )
            pairs.update((min(link, each), max(link, each)) for each in carriers if each != link)
        return frozenset(pairs)

    def way(self, link: str) -> tuple[UrdfJoint, ...]:
        """Return all joints between a link and the root, from the link upwards."""
        return way_to_root(link, self._parents)

    @cached_property
    def _moving(self) -> dict[str, tuple[str, ...]]:
        """Names of movable joints above links, filled on request."""
        return {}

    @cached_property
    def _branches(self) -> Mapping[str, list[UrdfJoint]]:
        """Joints by the link that carries them, in the file's order."""
        branches: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints.values():
            branches.setdefault(joint.parent, []).append(joint)
        return branches

    @cached_property
    def _parents(self) -> Mapping[str, UrdfJoint]:
        """Joints by the link that they move."""
        return {joint.child: joint for joint in self.joints.values()}


def is_named(link: str, pattern: str) -> bool:
    """Return whether a pattern of a robot document names a link; a trailing * matches any end."""
    start = pattern.removesuffix("*")
    return link == pattern or (start != pattern and link.startswith(start))


def way_to_root(link: str, parents: Mapping[str, UrdfJoint]) -> tuple[UrdfJoint, ...]:
    """Return all joints from a link up to the root; ``parents`` are joints by their child link."""
    way: list[UrdfJoint] = []
    while link in parents and len(way) < len(parents):  # bounded in case of a loop
        way.append(parents[link])
        link = way[-1].parent
    return tuple(way)

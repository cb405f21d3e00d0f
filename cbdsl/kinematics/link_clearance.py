"""Pairs of links that keep a distance from each other, and from places to keep out of."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.diagnostics.counting import some
from cbdsl.documents.robot import HullSection, RobotDocument
from cbdsl.kinematics.link_distance import (
    PAIR,
    SHAPE,
    DistanceArrays,
    measure_held,
    write_slope_held,
)
from cbdsl.kinematics.link_shapes import ConvexShape, link_shapes
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import hold
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel, is_named

# Number of sampled postures, and largest turn of unlimited joints in them, rad.
_SAMPLES, _TURN = 100, math.pi
#: Place of an object that is not seen, beyond every robot's reach, m.
FAR = HullSection(points=((0.0, 0.0, 1e3),))


class NearLinks(NamedTuple):
    """Two links, or a link and a place to keep out of, and their distance, m."""

    first: str
    second: str
    distance: float


class _Owner(NamedTuple):
    """Link or place of a shape."""

    name: str
    is_place: bool = False


class LinkClearance:
    """Distances between the links of a robot, of all pairs that can keep a clearance.

    Pairs whose links at most one joint moves against each other are left out, or joints of a hand
    alone. So are links that the document lets touch, and those nearer in each of 100 postures.
    Links keep the same distance from the places that the document names. Places may have the
    names of links.

    Attributes:
        arrays: Shapes and pairs in the form of compiled code.
        names: Names of the links of each pair.
        joints: Joints of the robot.

    Args:
        robot: Robot document.
        model: Model of the robot.
        least: Least distance, m.
        near: Distance beyond it at which pairs are near, m.
        share: Share of the way to it by which a pair may approach in a tick.
        margin: Distance beyond it at which approaching ends, m.
        counts: Predicate of the pairs that count, by the names of both links; all by default.

    Raises:
        UrdfError: If a value of a link is not a number.
    """

    def __init__(
        self,
        robot: RobotDocument,
        model: UrdfModel,
        least: float,
        near: float = 0.0,
        share: float = 0.0,
        margin: float = 0.0,
        counts: Callable[[str, str], bool] = lambda one, other: True,
    ) -> None:
        joints = Joints(robot)
        self._robot, self._model, self.joints = robot, model, joints
        tree = LinkTree(model, joints, robot.base)
        stated, shapes = robot.clearance, dict(link_shapes(model))
        shapes |= {link: tuple(map(_stated, each)) for link, each in stated.shapes.items()}
        own = [(_Owner(link), each) for link in tree.rows for each in shapes.get(link, ())]
        places = stated.keep_out.items()
        own += [(_Owner(name, is_place=True), _stated(each)) for name, each in places]
        owners = self._owners = [owner for owner, _ in own]
        # The frame of the base, which is the world's, carries the places to keep out of.
        frames = [0 if owner.is_place else tree.rows[owner.name] for owner in owners]
        records, offsets = _records([each for _, each in own], frames)
        movable = self._movable_pairs(list(dict.fromkeys(owners)))
        apart = {(one, other) for one, other in movable if counts(one.name, other.name)}
        chosen = [
            (first, second)
            for first, second in combinations(range(len(own)), 2)
            if (owners[first], owners[second]) in apart
        ]
        pairs: NDArray[Any] = np.zeros(len(chosen), PAIR)
        pairs["first"], pairs["second"] = np.array(chosen, np.int64).reshape(-1, 2).T
        pairs["simplex"] = -1
        self.arrays = DistanceArrays(
            records, offsets, offsets.copy(), np.zeros((len(records), 3)),
            np.zeros((len(records), 9)), pairs, *tree.chain,
            np.array((least, near, share, margin)), np.full(len(joints), math.nan),
        )  # fmt: skip
        self._keep(~self._always_near())
        self.names = tuple(
            (owners[first].name, owners[second].name)
            for first, second in self.arrays.pairs[["first", "second"]].tolist()
        )

    def measure(self, positions: Floats) -> None:
        """Compute the distances in a posture of the actuated joints, rad or m, shape (n,)."""
        measure_held(self._handle, positions)

    def slope(self, number: int) -> Floats:
        """Return the change of a near pair's distance per actuated joint, shape (n,)."""
        row = np.empty(len(self.joints))
        write_slope_held(self._handle, number, row)
        return row

    def place(self, name: str, centre: Floats, radius: float) -> None:
        """Move a ball to keep out of to a place in the world frame, m, shape (3,)."""
        shape, arrays = self._owners.index(_Owner(name, is_place=True)), self.arrays
        record = arrays.shapes[shape]
        record["centre"], record["radius"], record["reach"] = centre, radius, radius
        arrays.offsets[record["span"][0]] = centre
        # A lower bound on the distance, so that it is measured again.
        arrays.pairs["distance"][arrays.pairs["second"] == shape] = 0.0
        arrays.at[:] = math.nan

    def nearer(self, positions: Floats) -> list[NearLinks]:
        """Return the pairs of links that are nearer than the least distance, the nearest first."""
        self.measure(positions)
        pairs, least = self.arrays.pairs, self.arrays.bounds[0]
        nearest: dict[tuple[str, str], NearLinks] = {}
        for place in np.argsort(pairs["distance"]):
            distance, names = float(pairs["distance"][place]), self.names[place]
            if distance < least:
                nearest.setdefault(names, NearLinks(names[0], names[1], distance))
        return list(nearest.values())

    @property
    def start(self) -> Floats:
        """Positions of the actuated joints at the start of an episode, rad or m, shape (n,)."""
        joints = [self._model.joints[name] for name in self.joints.names]
        positions = np.array([min(max(0.0, each.lower), each.upper) for each in joints])
        for name, posture in self._robot.start_postures.items():
            positions[self.joints.of(name)] = posture
        return positions

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        """Keep some of the pairs."""
        self.arrays = self.arrays._replace(pairs=self.arrays.pairs[kept])
        self._handle = hold(self.arrays)

    def _always_near(self) -> NDArray[np.bool_]:
        """Return which pairs are closer than the clearance in all sampled postures."""
        self._handle = hold(self.arrays)
        limits = [self._model.joints[name] for name in self.joints.names]
        lower = np.array([max(each.lower, -_TURN) for each in limits])
        upper = np.array([min(each.upper, _TURN) for each in limits])
        rng, near = np.random.default_rng(0), np.ones(len(self.arrays.pairs), np.bool_)
        for _ in range(_SAMPLES if len(near) else 0):
            self.measure(rng.uniform(lower, upper))
            near &= self.arrays.pairs["distance"] < self.arrays.bounds[0]
        return near

    def _movable_pairs(self, owners: Sequence[_Owner]) -> Iterator[tuple[_Owner, _Owner]]:
        """Yield the pairs of links and places that may come near each other, and must not."""
        links = [owner for owner in owners if not owner.is_place]
        together = [
            {owner for owner in links if any(is_named(owner.name, pattern) for pattern in group)}
            for group in (*self._robot.simulation.no_contact, *self._robot.clearance.ignore)
        ]
        ways = {owner: self._turning(owner) for owner in owners}
        hands = [
            frozenset(each.joints) for each in self._robot.effectors.values() if each.tip is None
        ]
        for one, other in combinations(owners, 2):
            between = ways[one] ^ ways[other]
            leaders = frozenset(map(self._leader, between))
            is_place = one.is_place or other.is_place
            if (
                len(between) > 1 - is_place
                and (is_place or not any(leaders <= hand for hand in hands))
                and not any(one in group and other in group for group in together)
            ):
                yield one, other

    def _turning(self, owner: _Owner) -> frozenset[str]:
        """Return the joints that move a link, actuated or passive; none for a place."""
        way = () if owner.is_place else self._model.way(owner.name)
        return frozenset(joint.name for joint in way if joint.name in self.joints.index)

    def _leader(self, joint: str) -> str:
        couplings = self._robot.couplings
        return couplings[joint].follows if joint in couplings else joint


def with_places(robot: RobotDocument, places: Mapping[str, HullSection]) -> RobotDocument:
    """Return a robot whose links keep their distance from further places in the world frame."""
    kept = robot.clearance.model_copy(update={"keep_out": {**robot.clearance.keep_out, **places}})
    return robot.model_copy(update={"clearance": kept}) if places else robot


def too_near_at_start(robot: RobotDocument, model: UrdfModel, least: float) -> str:
    """Return a clause about the pairs of links that start nearer than ``least``, m, or no text."""
    links = LinkClearance(robot, model, least)
    if not links.names:
        return "no two links with collision geometry can come near each other"
    pairs = [
        f"{each.first} is {100 * max(each.distance, 0.0):.1f} cm from {each.second}"
        for each in links.nearer(links.start)
    ]
    return f"at the start {some(pairs)}, and the least is {100 * least:g} cm" if pairs else ""


def _stated(shape: HullSection) -> ConvexShape:
    return ConvexShape(np.array(shape.points, dtype=float), shape.radius)


def _records(shapes: Sequence[ConvexShape], frames: Sequence[int]) -> tuple[Any, Floats]:
    """Return records of ``SHAPE`` for shapes carried by frames, and all their points."""
    records: NDArray[Any] = np.zeros(len(shapes), SHAPE)
    first = 0
    for record, shape, frame in zip(records, shapes, frames, strict=True):
        last = first + len(shape.points)
        record["span"], record["frame"], record["radius"] = (first, last), frame, shape.radius
        centre = (shape.points.min(axis=0) + shape.points.max(axis=0)) / 2
        record["centre"] = centre
        reach = np.linalg.norm(shape.points - centre, axis=1).max()
        record["reach"], first = reach + shape.radius, last
    points = np.vstack([np.zeros((0, 3)), *(shape.points for shape in shapes)])
    return records, points

"""Nearest links: least distance between the links of an effector and other bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cbdsl.documents.robot import HullSection, RobotDocument
from cbdsl.kinematics.link_clearance import FAR, LinkClearance, with_places
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfModel
from cbdsl.types.resource import LinkDistance

# Differences of distances at which the longer one weighs less by a factor of e, and nothing, m.
_BLEND, _BEYOND = 0.005, 0.025


class NearestLinks:
    """Least distance between the links that an effector moves and other bodies.

    Pairs are left out as for a clearance. Pairs that are about as near as the nearest one share in
    the slope, since a level would otherwise push back and forth between them.

    Attributes:
        pair: Names of the links that were nearest at the last measurement.
        distance: Least distance, m, 0 in contact.
        are_known: True if a pair of links has shapes and can come near each other.

    Args:
        robot: Robot document.
        model: Model of the robot.
        source: Distance.
        hulls: Hulls around fixtures in the world frame, by name.
    """

    def __init__(
        self,
        robot: RobotDocument,
        model: UrdfModel,
        source: LinkDistance,
        hulls: Mapping[str, HullSection] = MappingProxyType({}),
    ) -> None:
        other = self._other = source.other
        own, members = set(robot.joints(source.effector)), robot.all_effectors
        joints = set(robot.joints(other)) if other in members else set[str]()

        def sides(link: str) -> tuple[bool, bool]:
            moving = {joint.name for joint in model.way(link)}
            is_other = other in ("", link) or not moving.isdisjoint(joints)
            return not moving.isdisjoint(own), is_other

        def is_meant(one: str, two: str) -> bool:
            (own_one, other_one), (own_two, other_two) = sides(one), sides(two)
            is_of_both = bool(joints) and own_one and other_one and own_two and other_two
            return ((own_one and other_two) or (own_two and other_one)) and not is_of_both

        places = {other: hulls.get(other, FAR)} if source.is_fixture or source.features else {}
        self._links = LinkClearance(with_places(robot, places), model, 0.0, 1.0, counts=is_meant)
        self.are_known, self.pair, self.distance = bool(self._links.names), "", math.inf

    def place(self, centre: Floats, radius: float) -> None:
        """Move the other body, a ball, to a place in the world frame, m, shape (3,)."""
        self._links.place(self._other, centre, radius)

    def measure(self, positions: Floats) -> Floats:
        """Measure the distance in a posture; return the mean slope of near pairs, shape (n,).

        Args:
            positions: Positions of the actuated joints, rad or m, shape (n,).
        """
        arrays, near = self._links.arrays, self._links.arrays.pairs["near"]
        distances, bounds = arrays.pairs["distance"], arrays.bounds
        self._links.measure(positions)
        # Objects may be far away. An infinite bound ends the search: no posture is finite then.
        while math.isfinite(bounds[1]) and not (near & (distances + _BEYOND <= bounds[1])).any():
            bounds[1], arrays.at[:] = 2.0 * bounds[1], math.nan
            self._links.measure(positions)
        least = float(np.min(distances, where=near, initial=math.inf))
        weights = np.exp((least - distances) / _BLEND) * (near & (distances <= least + _BEYOND))
        self.distance, bounds[1] = max(least, 0.0), max(least, 0.0) + 2.0 * _BEYOND
        self.pair = " and ".join(self._links.names[int(np.argmax(weights))])
        weights /= weights.sum()
        slopes = (weights[k] * self._links.slope(k) for k in np.flatnonzero(weights).tolist())
        return sum(slopes, np.zeros(len(positions)))

"""Grasps: an object between fingertips moves with them."""

# Model: a grasp by two fingertips with Coulomb friction is in equilibrium for any squeeze if the
# line between the contacts is inside of both friction cones (Nguyen 1988, "Constructing
# force-closure grasps"). With the inward unit normal n, the line d and the coefficient mu, that is
#     n . d / |d| >= cos(atan(mu)) = 1 / sqrt(1 + mu^2)
# Fingertips are springs, so the force at the depth e is k e. All fingertips of the holding hands
# together bear the weight m g if sum(mu k e) >= m g. Torques are neglected: an object held far from
# its centre of mass does not turn between the fingertips.

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from cbdsl.backends.kinematic.hands import FingertipContact, Hands
from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.staging.scenario import GRAVITY
from cbdsl.kinematics.pose import Pose

#: Force per depth of a fingertip, N/m. With it the force controllers of the robot file settle
#: within a few control ticks; the softness of a real fingertip would need faster ones.
STIFFNESS = 500.0


class Grasp:
    """Hands that hold one object.

    Two fingertips hold it under two conditions. The line between them lies within both of their
    friction cones, and the friction of all their hands' fingertips can bear its weight. Single
    hands come before pairs, and the current holders keep the object while these conditions hold.

    Attributes:
        thing: Object.
        holders: Names of the one or two hands that hold the object; empty if it is not held.
        rub: Vertical friction of all holding fingertips that balanced the forces along their
            normals when they last held the object in the air, N.
    """

    def __init__(self, thing: KinematicObject, hands: Hands) -> None:
        self.thing = thing
        self._hands = hands
        self._relative = Pose(np.zeros(3), np.eye(3))
        self._axis = 0
        self.holders: tuple[str, ...] = ()
        self.rub = 0.0

    @property
    def is_at_rest(self) -> bool:
        """True if the object stands still and is neither held nor gripped."""
        return self.thing.resting and not (self.holders or self.thing.gripped)

    def follow(self) -> None:
        """Move the object with the hands that hold it."""
        if self.holders:
            carrier = self._hands.carrier_pose(self.holders, self._axis)
            self.thing.put(carrier @ self._relative)

    def update(self, contacts: Sequence[FingertipContact]) -> None:
        """Find the hands that hold the object now, and its pose relative to them."""
        if not contacts:
            self.holders, self.rub = (), 0.0
            return
        # The holders keep the object: else it would change hands whenever another grasp is
        # possible.
        if not (self.holders and self._holds(self.holders, contacts)):
            hands = tuple(dict.fromkeys([contact.hand for contact in contacts]))
            wanted = (*((hand,) for hand in hands), *combinations(hands, 2))
            self.holders, self.rub = next((o for o in wanted if self._holds(o, contacts)), ()), 0.0
        if self.holders:
            self._axis = self._hands.cross_axis(self.holders)
            carrier, pose = self._hands.carrier_pose(self.holders, self._axis), self.thing.pose
            # The relative pose is stored in each tick, since fingertips may push the held object.
            turned = carrier.rotation.T
            self._relative = Pose(
                turned.dot(pose.position - carrier.position), turned.dot(pose.rotation)
            )

    def _holds(self, hands: tuple[str, ...], contacts: Sequence[FingertipContact]) -> bool:
        own = [contact for contact in contacts if contact.hand in hands]
        return self._resistance(own) >= self.thing.mass * GRAVITY and any(
            self._opposed(one, other) for one, other in combinations(own, 2)
        )

    def _opposed(self, one: FingertipContact, other: FingertipContact) -> bool:
        x, y, z = (there - here for here, there in zip(one.point, other.point, strict=True))
        distance = math.hypot(x, y, z)
        if distance == 0.0:
            return False
        for sign, contact in ((1, one), (-1, other)):
            u, v, w = contact.normal
            along = sign * (u * x + v * y + w * z)
            # The comparison is negated, so that values that are not numbers hold nothing.
            if not along * math.hypot(1.0, self._friction(contact)) >= distance:
                return False
        return True

    def _resistance(self, contacts: Sequence[FingertipContact]) -> float:
        """Return the largest tangential force that the friction of some fingertips resists, N."""
        return sum([self._friction(each) * STIFFNESS * each.depth for each in contacts])

    def _friction(self, contact: FingertipContact) -> float:
        return contact.fingertip.friction * self.thing.surface.friction

    def stick(self, contacts: Sequence[FingertipContact]) -> float:
        """Return the largest sideways force that the fingertips' friction resists, N."""
        if not self.holders:
            return 0.0
        return self._resistance(contacts)

"""Rigid holds: how what hands hold moves with them (Eq 3.42 and 3.43)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.kinematics import Point

Floats = NDArray[np.float64]

_UNTURNED = np.eye(3)


class Hold(NamedTuple):
    """Where the hands are that hold something, and how the joints move them.

    What one hand holds turns with it. What several hands hold moves with the mean of their tips
    and does not turn, since they keep facing each other.

    Attributes:
        arms: that carry the hands.
        position: of the tip, or the mean of several, m, world frame, shape (3,).
        rotation: of the one tip, or the identity, shape (3, 3).
        linear: velocity of ``position`` per joint, shape (3, n).
        angular: angular velocity of the one tip per joint in world axes, shape (3, n); ``None``
            for several.
    """

    arms: tuple[str, ...]
    position: Floats
    rotation: Floats
    linear: Floats
    angular: Floats | None

    @classmethod
    def of_one(cls, arm: str, tip: Point, rotation: Floats) -> Hold:
        """The hold of one hand, from its tip and the rotation of the link that carries it."""
        return cls((arm,), tip.position, rotation, tip.jacobian[:3], tip.jacobian[3:])

    @classmethod
    def of_several(cls, arms: tuple[str, ...], tips: Sequence[Point]) -> Hold:
        """The hold of several hands, from their tips."""
        share = 1.0 / len(tips)
        position, jacobian = (share * sum(each) for each in zip(*tips, strict=True))
        return cls(arms, position, _UNTURNED, jacobian[:3], None)

    def moved(self, before: Hold, position: Floats) -> Floats:
        """How far something held has moved, m, shape (3,).

        Args:
            before: where the hands were.
            position: where the thing was then, m, world frame, shape (3,).
        """
        own = before.rotation.T.dot(position - before.position)
        displacement: Floats = self.position + self.rotation.dot(own) - position
        return displacement

    def jacobian(self, position: Floats) -> Floats:
        """Displacement of something held at ``position`` per joint, shape (3, n)."""
        if self.angular is None:
            return self.linear
        x, y, z = (position - self.position).tolist()
        across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        jacobian: Floats = self.linear + across.dot(self.angular)
        return jacobian

"""Follower: a joint trajectory controller that holds still at the end of its trajectory."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl_ros2 import dds_types as msg

# Silence after which a writer loses its ownership of a controller, s; and after which a controller
# is not commanded.
_OWNED, _SILENT = 1.0, 0.3
# Time without a request after which a controller counts as stalled, s.
_STALLED = 0.1


class _Leg(NamedTuple):
    """Way between two references, by the wall clock, s since the epoch."""

    begun: float
    ends: float
    first: Floats
    last: Floats


class Follower:
    """Controller of some joints, as in ros2_controllers.

    A trajectory begins at its stamp, or at its arrival without one. A trajectory that is over
    already is refused. Bare positions become references immediately, and remain so.

    Args:
        names: Joints, by their names in messages.
        positions: References at rest, rad or m, shape (n,).
    """

    def __init__(self, names: tuple[str, ...], positions: Floats) -> None:
        self.names = names
        self._legs: list[_Leg] = []
        self._rest = np.array(positions)
        self._owner: tuple[int, float] | None = None
        # Newest references, and their time.
        self._newest, self._asked = self._rest, -math.inf

    def accept(self, message: object, writer: int, now: float) -> str:
        """Take a command.

        Args:
            message: ``JointTrajectory`` or ``Float64MultiArray``.
            writer: Identifier of its writer.
            now: Wall time, s since the epoch.

        Returns:
            The reason of a refusal; empty if the command is followed.
        """
        if self._owner is not None and self._owner[0] != writer and now - self._owner[1] < _OWNED:
            return "another writer commands these joints"
        problem = self._take(message, now)
        if not problem:
            self._owner = writer, now
        return problem

    def is_commanded(self, now: float) -> bool:
        """Return whether a command was followed shortly before a wall time, s since the epoch."""
        return self._owner is not None and now - self._owner[1] < _SILENT

    def _take(self, message: object, now: float) -> str:
        if isinstance(message, msg.Float64MultiArray):
            positions = np.array(message.data)
            if positions.shape != self._rest.shape or not np.isfinite(positions).all():
                return f"{len(message.data)} positions, or one that is not finite"
            self._rest, self._legs = positions, []
            return ""
        assert isinstance(message, msg.JointTrajectory)
        return self._take_trajectory(message, now)

    def _take_trajectory(self, message: msg.JointTrajectory, now: float) -> str:
        if sorted(message.joint_names) != sorted(self.names):
            return f"the trajectory is for joints {', '.join(message.joint_names) or 'none'}"
        stamp = message.header.stamp.seconds
        begun = stamp or now
        # Joints of a message come in any order.
        order = [list(message.joint_names).index(name) for name in self.names]
        # A trajectory starts from the reference of this moment, so that a new one causes no jump.
        legs, last, time = [], self._sample(now), max(begun, now)
        for point in message.points:
            if len(point.positions) != len(order) or not all(map(math.isfinite, point.positions)):
                return "a point lacks positions, or has some that are not finite"
            ends = begun + point.time_from_start.seconds
            positions = np.array(point.positions)[order]
            legs.append(_Leg(time, ends, last, positions))
            last, time = positions, ends
        if not legs or time <= now:
            return "the trajectory is over already"
        self._legs, self._rest = legs, last
        return ""

    def at(self, time: float) -> Floats:
        """Return the references at a wall time, rad or m, shape (n,).

        A controller that was stalled holds still instead of catching up.
        """
        if self._legs and time - self._asked > _STALLED:
            self._legs, self._rest = [], self._newest
        self._newest, self._asked = self._sample(time), time
        return self._newest.copy()

    def _sample(self, time: float) -> Floats:
        for leg in self._legs:
            if time < leg.ends:
                share = (time - leg.begun) / (leg.ends - leg.begun)
                return leg.first + min(max(share, 0.0), 1.0) * (leg.last - leg.first)
        return self._rest

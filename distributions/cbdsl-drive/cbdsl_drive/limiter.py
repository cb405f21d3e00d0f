"""Limiter: the last line between a program's references and a robot's controllers.

Each joint's reference is a point that moves in steps of one control period dt. Its velocity is
v = (p' - p) / dt. A step is chosen from the intersection of three intervals:

    acceleration    v0 - a dt <= v <= v0 + a dt
    velocity        -v_max <= v <= v_max
    position        -s(p - lower) <= v <= s(upper - p)

s(d) is the largest first velocity from which braking by a dt in each further step covers at most
the distance d: v dt + (v - a dt) dt + ... <= d. For v = n a dt the sum is a dt^2 n (n+1) / 2. It
is linear in v between these nodes, with the slope n dt. If v0 obeyed s one step earlier, the
lower end v0 - a dt obeys s now. So the intersection is never empty, and the position limits hold
by induction for every sequence of requests.

Distances beyond which s exceeds v_max change nothing. They are cut there, so that huge requests do
not overflow.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.extend.backend import Floats

#: Speed of references below which they stand, rad/s or m/s, and the longest time for which the
#: program of a standing robot may compute, s.
STANDING, COMPUTING = 0.02, 0.5


class JointLimits(NamedTuple):
    """Limits of n joints, rad or m; infinite without a limit.

    Attributes:
        lower, upper: Positions, shape (n,).
        velocity: Largest speeds, shape (n,).
        acceleration: Largest accelerations, shape (n,).
        effort: Largest torques or forces, shape (n,).
    """

    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    effort: Floats


class Limiter:
    """Moves references towards requested ones within all limits.

    Args:
        limits: Limits of the joints; velocity and acceleration are finite.
        period: Time between two references, s.

    Attributes:
        positions: Newest references, rad or m, shape (n,).
        velocities: Rates of the references, rad/s or m/s, shape (n,).
    """

    def __init__(self, limits: JointLimits, period: float) -> None:
        self._limits, self._period = limits, period
        # A distance from which braking takes longer than one from the largest speed, and which a
        # single step does not cover.
        braking = limits.velocity * limits.velocity / (2.0 * limits.acceleration)
        self._reach = braking + limits.velocity * period
        self.positions: Floats = np.zeros(len(limits.lower))
        self.velocities: Floats = np.zeros(len(limits.lower))

    @property
    def stands(self) -> bool:
        """True if no reference moves."""
        return not self.velocities.any()

    def reset(self, positions: Floats) -> None:
        """Start at rest from measured positions, rad or m, shape (n,)."""
        self.positions = np.array(positions, dtype=np.float64)
        self.velocities = np.zeros_like(self.positions)

    def approach(self, requested: Floats) -> Floats:
        """Return the next references on the way to requested ones.

        Args:
            requested: Positions, rad or m, shape (n,); a joint brakes if its entry is not finite.
        """
        way = np.where(np.isfinite(requested), requested, self.positions) - self.positions
        # The first bound ends the step at the request. The second one leaves room to brake before
        # it.
        distance = np.minimum(np.abs(way), self._reach)
        speed = np.minimum(distance / self._period, self._stoppable(distance))
        return self._move(np.copysign(speed, way))

    def brake(self) -> Floats:
        """Return the next references of joints that brake as fast as their limits allow."""
        return self._move(np.zeros_like(self.velocities))

    def _move(self, velocities: Floats) -> Floats:
        limits, before, step = (
            self._limits,
            self.velocities,
            self._limits.acceleration * self._period,
        )
        up = np.minimum(self._stoppable(limits.upper - self.positions), limits.velocity)
        down = np.minimum(self._stoppable(self.positions - limits.lower), limits.velocity)
        # The second interval is applied last. The intersection is not empty, so the result is in
        # both.
        allowed = np.clip(velocities, before - step, before + step)
        allowed = np.clip(allowed, -down, up)
        moved = self.positions + allowed * self._period
        # Rounding must not carry a reference over a limit; a joint that starts outside may return.
        inside = (self.positions >= limits.lower) & (self.positions <= limits.upper)
        self.positions = np.where(inside, np.clip(moved, limits.lower, limits.upper), moved)
        self.velocities = allowed
        return self.positions.copy()

    def _stoppable(self, distances: Floats) -> Floats:
        """Return the largest speeds from which joints brake within distances, shape (n,)."""
        step = self._limits.acceleration * self._period
        unit = step * self._period
        room = np.minimum(np.maximum(distances, 0.0), self._reach)
        # The node n solves a dt^2 n (n + 1) / 2 = d. Below it, the distance left from the node n -
        # 1 is covered at the slope n dt.
        nodes = np.ceil((np.sqrt(1.0 + 8.0 * room / unit) - 1.0) / 2.0)
        below = np.maximum(nodes - 1.0, 0.0)
        rest = room - unit * below * nodes / 2.0
        speeds = below * step + rest / (np.maximum(nodes, 1.0) * self._period)
        return np.maximum(speeds, 0.0)

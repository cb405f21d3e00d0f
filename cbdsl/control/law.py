"""The prioritised control law: ``c2 ◁ c1`` for any number of levels (Section 3.3.2, Eq 3.26)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cbdsl.control.inverse import Damping
from cbdsl.control.row_space import RowSpace
from cbdsl.control.selection import Booleans
from cbdsl.control.signal import Floats, SignalError, require_finite

# Bounds are this much wider, rad, so that rounding never counts as passing one.
_SLACK = 1e-12


@dataclass(frozen=True)
class Level:
    """What one controller wants in this tick.

    Attributes:
        name: the controller, for messages and explanations.
        jacobian: task coordinates per joint, shape (k, n).
        velocity: wanted displacement of the task coordinates in this tick, gain and bounds
            applied, shape (k,).
    """

    name: str
    jacobian: Floats
    velocity: Floats


@dataclass(frozen=True)
class LawSettings:
    """Guards of the law.

    Attributes:
        joint_step: largest displacement of a joint in one tick, rad.
        damping: largest damping of a step, in the square of the Jacobians' unit.
        singular_value: singular value below which damping sets in, in the Jacobians' unit.
        limit_margin: distance that joints keep from their limits, rad.
    """

    joint_step: float
    damping: float = 0.01
    singular_value: float = 0.04
    limit_margin: float = 0.01


@dataclass(frozen=True)
class LevelReport:
    """Why a level moved as it did.

    Attributes:
        name: the controller.
        share: part of the wanted displacement that the tick achieves to first order: 1 in full,
            0 where higher levels, limits or singularities leave nothing, negative where higher
            levels move the task away.
        rank: independent task coordinates that higher levels and limits leave.
        singular_value: the smallest singular value among them, 0 where none is left.
    """

    name: str
    share: float
    rank: int
    singular_value: float


@dataclass(frozen=True)
class Step:
    """The result of one tick.

    Attributes:
        displacement: of the joints, rad, shape (n,).
        locked: joints that a limit held back, shape (n,).
        levels: what was wanted, highest priority first.
        spaces: what each level had to leave alone.
    """

    displacement: Floats
    locked: Booleans
    levels: tuple[Level, ...]
    spaces: tuple[RowSpace, ...]

    @cached_property
    def reports(self) -> tuple[LevelReport, ...]:
        """Explains each level, highest priority first."""
        return tuple(
            self._report(level, space)
            for level, space in zip(self.levels, self.spaces, strict=True)
        )

    def _report(self, level: Level, space: RowSpace) -> LevelReport:
        size = float(np.linalg.norm(level.jacobian))
        values = space.singular_values(level.jacobian, size)
        achieved = level.jacobian @ self.displacement
        wanted = float(level.velocity @ level.velocity)
        share = float(level.velocity @ achieved) / wanted if wanted else 1.0
        smallest = float(values[-1]) if len(values) else 0.0
        return LevelReport(level.name, share, len(values), smallest)


class Law:
    """Composes levels so that no level disturbs one above it.

    Each level acts only through joint displacements that no higher level responds to; an
    orthonormal basis of the rows above makes the projection exact, whatever their ranks. Steps,
    never the basis, are damped near singularities. Where a level would make the sum too long, its
    own step is shortened as a whole. A joint that a level would push past a limit is fixed for
    that level and those below it, and the level is solved again with the other joints, so that a
    limit takes nothing from higher levels. A joint beyond its limit is moved back, no more than
    ``settings.joint_step`` a tick, while the other joints make up for it.

    Args:
        lower: lower joint limits, rad, shape (n,); may be infinite.
        upper: upper joint limits, rad, shape (n,).
        settings: the guards.

    Raises:
        ValueError: the margin leaves a joint no room.
    """

    def __init__(self, lower: Floats, upper: Floats, settings: LawSettings) -> None:
        self._settings = settings
        self._damping = Damping(settings.damping, settings.singular_value)
        self._nothing = RowSpace.empty(len(lower))
        if not (lower + settings.limit_margin <= upper - settings.limit_margin).all():
            raise ValueError("a joint's limits are closer together than twice their margin")
        self._lower = lower + settings.limit_margin - _SLACK
        self._upper = upper - settings.limit_margin + _SLACK

    def solve(self, levels: Sequence[Level], q: Floats) -> Step:
        """One tick's displacement.

        Args:
            levels: highest priority first.
            q: joint positions, rad, shape (n,).

        Raises:
            SignalError: the posture or a level is not finite, or a level's shape does not fit.
        """
        require_finite(q, "the posture")
        lowest, highest = self._lower - q, self._upper - q
        composition = _Composition(
            lowest, highest, self._settings.joint_step, self._damping, self._nothing
        )
        spaces = tuple([composition.add(level) for level in levels])
        locked = composition.locked
        return Step(
            composition.displacement(),
            np.zeros(len(q), dtype=bool) if locked is None else locked,
            tuple(levels),
            spaces,
        )


class _Composition:
    """The displacement of the levels composed so far, and the joints' directions that they took.

    Args:
        lowest: smallest displacement within the limits, positive below the lower one, shape (n,).
        highest: largest displacement within the limits, shape (n,).
        step: largest displacement of a joint.
        damping: of the steps.
        taken: the row space of no rows.
    """

    def __init__(
        self, lowest: Floats, highest: Floats, step: float, damping: Damping, taken: RowSpace
    ) -> None:
        self._step = step + _SLACK
        self._damping = damping
        # Limits come before what the levels want, the largest step before limits.
        most = self._step + _SLACK
        self._lowest = np.maximum(np.minimum(lowest, step), -most)
        self._highest = np.minimum(np.maximum(highest, -step), most)
        self._sum = np.zeros(len(lowest))
        self._taken = taken
        self.locked: Booleans | None = None

    def displacement(self) -> Floats:
        """The displacement of all joints, within limits and the largest step."""
        return np.minimum(np.maximum(self._sum, self._lowest), self._highest)

    def add(self, level: Level) -> RowSpace:
        """Compose one more level below the others; returns what it had to leave alone.

        Every pass locks a joint or is the last, so there are at most n + 1.
        """
        rows, size = level.jacobian, _size(level, len(self._sum))
        while True:
            above = self._taken
            inverse = above.inverse(rows, size, self._damping)
            if inverse is None:
                return above
            change = inverse.displacement(level.velocity - rows.dot(self._sum))
            if self.locked is not None:
                change[self.locked] = 0.0  # not rounding, which could look like passing a bound
            target = self._sum + change
            if not np.count_nonzero(self._exceeds(target)):
                break
            target = self._sum + change * self._share(change)
            stopped = self._exceeds(target)
            if not np.count_nonzero(stopped):
                break
            self._lock(stopped)
        self._sum = target
        self._taken = above.extended(inverse)
        return above

    def _exceeds(self, target: Floats) -> Booleans:
        """Joints that would pass a bound, or not come back from beyond a limit."""
        outside: Booleans = (target < self._lowest) | (target > self._highest)
        return outside

    def _share(self, change: Floats) -> float:
        """The part of a change that keeps every joint within the largest step."""
        room = np.maximum(self._step - np.sign(change) * self._sum, 0.0)
        size = np.abs(change)
        too_far = size > room + _SLACK
        return float((room[too_far] / size[too_far]).min()) if too_far.any() else 1.0

    def _lock(self, joints: Booleans) -> None:
        """Keep joints where they are, or where they have to go to come inside their limits."""
        self.locked = joints if self.locked is None else self.locked | joints
        self._sum = np.where(joints, self.displacement(), self._sum)
        rows = np.eye(len(joints))[joints]
        inverse = self._taken.inverse(rows, float(len(rows)) ** 0.5, self._damping)
        if inverse is not None:
            self._taken = self._taken.extended(inverse)


def _size(level: Level, joints: int) -> float:
    """Frobenius norm of a level's Jacobian, once the level is found to be sound."""
    rows, velocity = level.jacobian, level.velocity
    if rows.shape != (len(velocity), joints):
        raise SignalError(
            f"{level.name} wants {len(velocity)} coordinates of {joints} joints, "
            f"but its Jacobian has shape {rows.shape}"
        )
    # A norm is finite only where all numbers are.
    size = math.sqrt(float(np.vdot(rows, rows)))
    if not math.isfinite(size + float(velocity.dot(velocity))):
        require_finite(rows, f"the Jacobian of {level.name}")
        require_finite(velocity, f"the velocity of {level.name}")
    return size

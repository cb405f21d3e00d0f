"""The prioritised control law: ``c2 ◁ c1`` for any number of levels (Section 3.3.2, Eq 3.26)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.nullspace import Damping, Nullspace
from cbdsl.control.signal import Floats, SignalError, require_finite

Booleans = NDArray[np.bool_]


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
        reports: one per level, highest priority first.
    """

    displacement: Floats
    locked: Booleans
    reports: tuple[LevelReport, ...]


class Law:
    """Composes levels so that no level disturbs one above it.

    Each level acts only through joint displacements that all higher levels are insensitive to; an
    orthonormal basis of those makes the projection exact, whatever the ranks. Steps, never the
    basis, are damped near singularities. A step that would be too long is shortened as a whole
    at the level that lengthens it. A joint that a level would push past a limit is fixed for that
    level and those below it, and the level is solved again with the other joints, so that a limit
    takes nothing from higher levels. A joint beyond its limit is moved back at no more than
    ``settings.joint_step`` a tick, while the other joints make up for it.

    Args:
        lower: lower joint limits, rad, shape (n,); may be infinite.
        upper: upper joint limits, rad, shape (n,).
        settings: the guards.

    Raises:
        ValueError: the margin leaves a joint no room.
    """

    def __init__(self, lower: Floats, upper: Floats, settings: LawSettings) -> None:
        self._lower = lower + settings.limit_margin
        self._upper = upper - settings.limit_margin
        self._settings = settings
        if not (self._lower <= self._upper).all():
            raise ValueError("a joint's limits are closer together than twice their margin")

    def solve(self, levels: Sequence[Level], q: Floats) -> Step:
        """One tick's displacement.

        Args:
            levels: highest priority first.
            q: joint positions, rad, shape (n,).

        Raises:
            SignalError: the posture or a level is not finite, or a level's shape does not fit.
        """
        require_finite(q, "the posture")
        composition = _Composition(self._lower - q, self._upper - q, self._settings)
        reports = tuple(composition.add(level) for level in levels)
        return Step(composition.displacement(), composition.locked, reports)


class _Composition:
    """The displacement of the levels composed so far, and the freedom left below them.

    Args:
        lowest: smallest displacement within the limits, positive below the lower one, shape (n,).
        highest: largest displacement within the limits, shape (n,).
    """

    def __init__(self, lowest: Floats, highest: Floats, settings: LawSettings) -> None:
        self._step = settings.joint_step
        self._damping = Damping(settings.damping, settings.singular_value)
        self._lowest = np.minimum(lowest, settings.joint_step)
        self._highest = np.maximum(highest, -settings.joint_step)
        self._sum = np.zeros(len(lowest))
        self._free = Nullspace.whole(len(lowest))
        self.locked: Booleans = np.zeros(len(lowest), dtype=bool)

    def displacement(self) -> Floats:
        """The displacement of all joints, within limits and the largest step."""
        return np.clip(self._sum, self._lowest, self._highest)

    def add(self, level: Level) -> LevelReport:
        """Compose one more level below the others.

        Every pass locks a joint or is the last, so there are at most n + 1.
        """
        _check(level, len(self._sum))
        while True:
            decomposition = self._free.decompose(level.jacobian)
            missing = level.velocity - level.jacobian @ self._sum
            step = decomposition.displacement(missing, self._damping)
            target = self._sum + self._shortened(step)
            stopped = ~self.locked & ((target < self._lowest) | (target > self._highest))
            if not stopped.any():
                break
            self._lock(stopped)
        self._sum = target
        self._free = decomposition.remaining()
        return _report(level, level.jacobian @ target, decomposition.values)

    def _shortened(self, step: Floats) -> Floats:
        """As much of ``step`` as keeps every joint's sum within the largest step."""
        room = self._step - np.sign(step) * self._sum
        size = np.abs(step)
        too_long = size > room
        if not too_long.any():
            return step
        return step * float((room[too_long] / size[too_long]).min())

    def _lock(self, joints: Booleans) -> None:
        """Keep joints where they are, or where they have to go to come inside their limits."""
        self.locked |= joints
        self._sum = np.where(joints, self.displacement(), self._sum)
        rows = np.eye(len(joints))[joints]
        self._free = self._free.decompose(rows).remaining()


def _check(level: Level, joints: int) -> None:
    if level.jacobian.shape != (len(level.velocity), joints):
        raise SignalError(
            f"{level.name} wants {len(level.velocity)} coordinates of {joints} joints, "
            f"but its Jacobian has shape {level.jacobian.shape}"
        )
    require_finite(level.jacobian, f"the Jacobian of {level.name}")
    require_finite(level.velocity, f"the velocity of {level.name}")


def _report(level: Level, achieved: Floats, values: Floats) -> LevelReport:
    wanted = float(level.velocity @ level.velocity)
    share = float(level.velocity @ achieved) / wanted if wanted else 1.0
    return LevelReport(level.name, share, len(values), float(values[-1]) if len(values) else 0.0)

"""The prioritised control law: ``c2 ◁ c1`` for any number of levels (Section 3.3.2, Eq 3.26)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from cbdsl.control.composition import Booleans, Integers, compose, midway
from cbdsl.control.signal import Floats, SignalError, require_finite


class Level(NamedTuple):
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


@dataclass
class Step:
    """The result of one tick.

    Attributes:
        displacement: of the joints, rad, shape (n,).
        locked: joints that a limit held back, shape (n,).
        singular_values: of what was left to each level, unsorted and 0 where its rows were
            dependent, level by level, shape (k,).
        asked: the levels as they were asked for, highest priority first.
        rows: their Jacobians, level by level, shape (k, n).
        past: the same one tick before and two, as far as known, shape (k, n) each.
        ends: the index after the last row of each level, shape (levels,).
    """

    displacement: Floats
    locked: Booleans
    singular_values: Floats
    asked: Sequence[Level]
    rows: Floats
    past: Sequence[Floats]
    ends: Integers

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The levels, highest priority first, with the Jacobians that the law went by."""
        rows = np.split(midway(self.rows, *_recent(self.rows, self.past)), self.ends[:-1])
        return tuple(
            level._replace(jacobian=each) for level, each in zip(self.asked, rows, strict=True)
        )

    @cached_property
    def reports(self) -> tuple[LevelReport, ...]:
        """Explains each level, highest priority first."""
        found, end = [], 0
        for level in self.levels:
            start, end = end, end + len(level.velocity)
            values = self.singular_values[start:end]
            found.append(self._report(level, values[values > 0.0]))
        return tuple(found)

    def _report(self, level: Level, values: Floats) -> LevelReport:
        achieved = level.jacobian @ self.displacement
        wanted = float(level.velocity @ level.velocity)
        share = float(level.velocity @ achieved) / wanted if wanted else 1.0
        smallest = float(values.min()) if len(values) else 0.0
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
        if not (lower + settings.limit_margin <= upper - settings.limit_margin).all():
            raise ValueError("a joint's limits are closer together than twice their margin")
        self._limits = np.stack((lower + settings.limit_margin, upper - settings.limit_margin))
        self._guards = settings.joint_step, settings.damping, settings.singular_value

    def solve(self, levels: Sequence[Level], q: Floats, past: Sequence[Floats] = ()) -> Step:
        """One tick's displacement.

        Jacobians of where a tick starts let a lower level move those above by the square of its
        step, tick after tick; those of its middle, by the cube. With those of ticks before, the
        law goes by what they will be half a tick ahead: one takes it that the arm goes on evenly,
        two that it goes on gaining or losing speed.

        Args:
            levels: highest priority first.
            q: joint positions, rad, shape (n,).
            past: the levels' Jacobians one tick before and two, as far as known, level by level,
                shape (k, n) each.

        Raises:
            SignalError: the posture or a level is not finite, or a level's shape does not fit.
        """
        rows, wanted, ends = _stacked(levels, len(q))
        before, earlier = _recent(rows, past)
        displacement, locked, values = compose(
            rows, before, earlier, wanted, ends, q, self._limits, *self._guards
        )
        if math.isnan(displacement.item(0)):
            _require_sound(levels, q)
        return Step(displacement, locked, values, levels, rows, past, ends)


def _recent(rows: Floats, past: Sequence[Floats]) -> Sequence[Floats]:
    """Jacobians one tick before and two; what is not known is as if they had turned evenly."""
    match past:
        case ():
            return rows, rows
        case (before,):
            return before, 2.0 * before - rows
    return past


def _stacked(levels: Sequence[Level], joints: int) -> tuple[Floats, Floats, Integers]:
    """Jacobians, velocities, and the index after the last row of each level."""
    if not levels:
        return np.empty((0, joints)), np.empty(0), np.empty(0, dtype=np.int64)
    jacobians = [level.jacobian for level in levels]
    velocities = [level.velocity for level in levels]
    counts = tuple([len(each) for each in velocities])
    shapes, ends = _layout(counts, joints)
    if [each.shape for each in jacobians] != shapes:
        _refuse(levels, joints)
    return np.concatenate(jacobians), np.concatenate(velocities), ends


@cache
def _layout(counts: tuple[int, ...], joints: int) -> tuple[list[tuple[int, int]], Integers]:
    """What shapes levels of so many rows have, and where each ends."""
    return [(count, joints) for count in counts], np.cumsum(counts)


def _refuse(levels: Sequence[Level], joints: int) -> None:
    """Say which level's shape does not fit."""
    for level in levels:
        if level.jacobian.shape != (len(level.velocity), joints):
            raise SignalError(
                f"{level.name} wants {len(level.velocity)} coordinates of {joints} joints, "
                f"but its Jacobian has shape {level.jacobian.shape}"
            )


def _require_sound(levels: Sequence[Level], q: Floats) -> None:
    """Say which number is not finite."""
    require_finite(q, "the posture")
    for level in levels:
        require_finite(level.jacobian, f"the Jacobian of {level.name}")
        require_finite(level.velocity, f"the velocity of {level.name}")
    raise SignalError("the levels' numbers are too large to compute with")

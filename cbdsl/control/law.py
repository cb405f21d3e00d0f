"""Prioritised control law: ``c2 ◁ c1`` for any number of levels (Section 3.3.2, Eq 3.26)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.composition import ComposedArrays, compose_held
from cbdsl.control.law_arrays import LawArrays
from cbdsl.control.level import Level
from cbdsl.control.signal import SignalError, require_finite
from cbdsl.control.stack import Stack
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import Handle, hold


@dataclass(frozen=True)
class LawSettings:
    """Guards of the law.

    Attributes:
        joint_step: Largest displacement of a joint in one tick, rad.
        damping: Largest damping of a step, in the square of the Jacobians' unit.
        singular_value: Singular value below which damping sets in, in the Jacobians' unit.
        limit_margin: Distance that joints keep from their limits, rad.
        lead: Largest distance of a joint's reference from its position, rad.
    """

    joint_step: float
    damping: float = 0.01
    singular_value: float = 0.04
    limit_margin: float = 0.01
    lead: float = math.inf


@dataclass(frozen=True)
class LevelReport:
    """Explanation of a level's motion.

    Attributes:
        name: Name of the controller.
        share: Part of the requested displacement that the tick achieves to first order. 1 is the
            whole, 0 nothing because of higher levels, limits or singularities. It is negative if
            higher levels move the task away, and above 1 if they move it further than requested.
        rank: Number of independent task coordinates that higher levels and limits leave.
        singular_value: Smallest singular value among them, 0 if there is none.
    """

    name: str
    share: float
    rank: int
    singular_value: float


@dataclass(slots=True)
class Step:
    """Result of one tick, valid until the next tick of the same stack.

    Attributes:
        displacement: Displacement of the joints, rad, shape (n,).
        locked: True for joints that a limit held back, shape (n,).
        singular_values: Singular values of the rows left to each level, level by level, shape (k,);
            unsorted, and 0 for dependent rows.
        stack: Stack of the composed levels.
    """

    displacement: Floats
    locked: NDArray[np.bool_]
    singular_values: Floats
    stack: Stack

    @classmethod
    def of(cls, stack: Stack) -> Step:
        """Return an empty result for a stack."""
        _, rows, joints = stack.rows.shape
        return cls(np.zeros(joints), np.zeros(joints, dtype=np.bool_), np.zeros(rows), stack)

    @property
    def levels(self) -> tuple[Level, ...]:
        """Levels that acted, highest priority first, with the Jacobians that the law used."""
        return self.stack.extrapolated()

    @property
    def reports(self) -> tuple[LevelReport, ...]:
        """Explanations of the levels, highest priority first."""
        values = self.stack.split(self.singular_values)
        return tuple(
            self._report(level, singular[singular > 0.0])
            for level, singular in zip(self.levels, values, strict=True)
        )

    def require_sound(self, q: Floats) -> None:
        """Raise an error that names the number that is not finite.

        Args:
            q: Joint positions, rad, shape (n,).

        Raises:
            SignalError: In every case; the message names the number.
        """
        require_finite(q, "the posture")
        for level in self.levels:
            require_finite(level.jacobian, f"the Jacobian of {level.name}")
            require_finite(level.velocity, f"the velocity of {level.name}")
        raise SignalError("the levels' numbers are too large to compute with")

    def _report(self, level: Level, values: Floats) -> LevelReport:
        achieved = level.jacobian @ self.displacement
        wanted = float(level.velocity @ level.velocity)
        share = float(level.velocity @ achieved) / wanted if wanted else 1.0
        smallest = float(values.min()) if len(values) else 0.0
        return LevelReport(level.name, share, len(values), smallest)


class Law:
    """Composition of levels in which no level disturbs a higher one.

    Each level acts only through joint displacements that do not affect higher levels. An
    orthonormal basis of the rows above makes the projection exact, for all ranks. Steps are damped
    near singularities, the basis never. If a level would make the sum too long, its own step is
    shortened as a whole. A joint that a level would push past a limit is taken there and fixed for
    that level and those below it. The level is then solved again with the other joints, so that a
    limit takes nothing from higher levels. A joint beyond its limit is moved back by at most
    ``settings.joint_step`` a tick, while the other joints compensate.

    If a level cannot achieve its displacement, its step is Newton's, by the Hessians of its
    coordinates and of the levels above (``second_order``). The directions in which it is displaced
    by the square of a step are withheld from the levels below, so that all come to rest.

    With Jacobians at the start of a tick, a lower level moves those above by the square of its
    step. With Jacobians at its middle, it moves them by the cube. Jacobians are therefore
    extrapolated half a tick ahead: linearly from one earlier tick, quadratically from two.

    Args:
        lower: Lower joint limits, rad, shape (n,); may be infinite.
        upper: Upper joint limits, rad, shape (n,).
        settings: Guards of the law.
        steps: Largest displacement of each joint in a tick, rad, shape (n,), if it is less than
            that of the guards.

    Raises:
        ValueError: If the margin leaves a joint no room.
    """

    def __init__(
        self, lower: Floats, upper: Floats, settings: LawSettings, steps: Floats | None = None
    ) -> None:
        if not (lower + settings.limit_margin <= upper - settings.limit_margin).all():
            raise ValueError("a joint's limits are closer together than twice their margin")
        self._limits = np.stack((lower + settings.limit_margin, upper - settings.limit_margin))
        self._steps = np.full(len(lower), settings.joint_step)
        if steps is not None:
            self._steps = np.minimum(self._steps, steps)
        self._guards = np.array((settings.damping, settings.singular_value, settings.lead))
        self._last: tuple[Step, Handle] | None = None

    def arrays(self, step: Step) -> LawArrays:
        """Return bounds and guards in the form of compiled code, with a step as the result."""
        return LawArrays(
            self._limits, self._steps, self._guards,
            step.displacement, step.locked, step.singular_values,
        )  # fmt: skip

    def solve(self, levels: Sequence[Level], q: Floats) -> Step:
        """Return one tick's displacement for levels without history.

        Args:
            levels: Levels, highest priority first.
            q: Joint positions, rad, shape (n,).

        Raises:
            SignalError: If the posture or a level is not finite, or a level's shape does not fit.
        """
        return self.compose(Stack.of(levels, len(q)), q)

    def compose(self, stack: Stack, q: Floats) -> Step:
        """Return one tick's displacement of a stack, whose levels may have acted earlier.

        Args:
            stack: Levels of this tick and the preceding ones.
            q: Joint positions, rad, shape (n,).

        Raises:
            SignalError: If the posture or a level is not finite.
        """
        step, handle = self._held_by(stack)
        for bends in (False, True):
            if not compose_held(handle, q, bends):
                break
        if math.isnan(step.displacement.item(0)):
            step.require_sound(q)
        return step

    def _held_by(self, stack: Stack) -> tuple[Step, Handle]:
        """Return the step of a stack, and a handle of its arrays."""
        last = self._last
        if last is None or last[0].stack is not stack:
            step = Step.of(stack)
            last = self._last = step, hold(ComposedArrays(stack.arrays, self.arrays(step)))
        return last

"""One controller's wish in one tick: from its feedback, or an evaluation, to a level of the law."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.composition import Integers
from cbdsl.control.kernel import act
from cbdsl.control.level import Level
from cbdsl.control.potential import Evaluation, Potential
from cbdsl.control.rate import bounds_of, displace, norm
from cbdsl.control.signal import Floats, require_finite
from cbdsl.control.stack import Stack
from cbdsl.numeric.compiled import compiled_once
from cbdsl.program.controller import Controller
from cbdsl.sensing.reading import Reading
from cbdsl.types.potential import POTENTIALS

_NOTHING = np.zeros((0, 0, 0))


class Task:
    """The rate kappa * step of a controller's task coordinates, within its speed and acceleration.

    Where there is an acceleration, the task brakes in time to stop at its goal.

    Args:
        controller: gives gain, speed, acceleration and the type of the feedback.
        potential: of the controller.
        period: of the control ticks, s.

    Attributes:
        bounds: see ``bounds_of``.
        before: displacement of the task coordinates in the tick before, shape (k,).
    """

    def __init__(self, controller: Controller, potential: Potential, period: float) -> None:
        self._name = controller.name
        self._compiled = potential.compiled
        self._is_scalar = POTENTIALS[controller.potential].scalar
        self.bounds = bounds_of(controller, period)
        self.before: Floats = np.zeros(potential.size)

    def reset(self) -> None:
        """Start from rest: the controller was activated."""
        self.before[:] = 0.0

    def join(self, stack: Stack, place: int, columns: Integers) -> None:
        """Let ``act`` write to a stack.

        Args:
            stack: where the level goes.
            place: of the level in the stack.
            columns: which joint each of the stack's n is, -1 for those that count as still.
        """
        self._stack = stack
        self._level = stack.rows, stack.wanted, stack.ages, stack.starts.item(place), place
        self._columns = columns

    def act(self, feedback: Reading, reference: Floats, raised: float) -> tuple[float, float]:
        """Let a controller whose potential is compiled act in this tick, all at once.

        Args:
            feedback: with its Jacobian by all joints.
            reference: what the feedback shall become, shaped like its value.
            raised: how far above its reference a position is sent to, m.

        Returns:
            phi and the residual's norm. They are NaN, and nothing acts, where the potential is not
            compiled, or not for these numbers; ``Potential.evaluate`` knows what to do.
        """
        if self._compiled is None:
            return math.nan, math.nan
        (kind, constants), (value, jacobian, _, _, curvature) = self._compiled, feedback
        if curvature is None:
            curvature = _NOTHING
        newest = self._stack.newest
        found: tuple[float, float] = act(
            kind,
            constants,
            value.ravel(),
            jacobian,
            curvature,
            reference.ravel(),
            raised,
            newest,
            self.bounds,
            self.before,
            self._columns,
            *self._level,
        )
        return found

    def level(self, evaluation: Evaluation) -> Level:
        """The displacement of the task coordinates that is wanted in this tick.

        Raises:
            SignalError: the evaluation is not finite; the message names the controller.
        """
        _, residual, jacobian, step = evaluation
        scale = 1.0
        if self._is_scalar:
            jacobian, scale = _unit(jacobian)
        if not displace(step, residual, jacobian, scale, self.bounds, self.before):
            require_finite(step, f"the step of {self._name}")
        return Level(self._name, jacobian, self.before.copy())


@compiled_once
def _unit(gradient: Floats) -> tuple[Floats, float]:
    """A scalar potential's gradient (1, n) made a unit vector, and what its coordinate scales by.

    What the joints do is the same. But the unit of a row says nothing about how near it is to
    losing its influence, and the law would take a short gradient for a singularity and damp it.
    """
    length = norm(gradient.ravel())
    return (gradient / length, 1.0 / length) if length > 0.0 else (gradient, 0.0)

"""One controller's wish in one tick: from an evaluation to a level of the law."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.law import Level
from cbdsl.control.potential import Evaluation
from cbdsl.control.signal import Floats, require_finite
from cbdsl.program.controller import Controller
from cbdsl.robot.compiled import compiled, compiled_once
from cbdsl.types.potential import POTENTIALS

# What a speed bounds.
_NORM, _LARGEST, _JOINTS = 0, 1, 2

_FORCES = frozenset({"force", "torque", "wrench"})


class Task:
    """The rate kappa * step of a controller's task coordinates, within its speed and acceleration.

    The speed bounds the largest component of a configuration, in rad/s, and the norm of anything
    else. Forces, and potentials without a residual, move only as fast as the joints that move them:
    their speed is one of the joints, rad/s, and bounds every force of a product by itself.

    Where there is an acceleration, the task brakes in time to stop at its goal.

    Args:
        controller: gives gain, speed, acceleration and the type of the feedback.
        period: of the control ticks, s.
    """

    def __init__(self, controller: Controller, period: float) -> None:
        self._name = controller.name
        self._gain = controller.gain
        self._speed = math.inf if controller.speed is None else controller.speed
        acceleration = controller.acceleration
        self._acceleration = math.inf if acceleration is None else acceleration
        self._kind = controller.feedback.type
        forces = self._kind.name in _FORCES
        potential = POTENTIALS[controller.potential]
        self._is_scalar = not potential.residual and not potential.field
        self._factors = self._kind.factors if forces else 1
        self._measure = _JOINTS if forces or self._is_scalar else _NORM
        if self._kind.name == "configuration" and self._measure == _NORM:
            self._measure = _LARGEST
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Start from rest: the controller was activated."""
        self._before: Floats | None = None

    def level(self, evaluation: Evaluation) -> Level:
        """The displacement of the task coordinates that is wanted in this tick.

        Raises:
            SignalError: the evaluation is not finite; the message names the controller.
        """
        _, residual, jacobian, step = evaluation
        scale = 1.0
        if self._is_scalar:
            jacobian, scale = _unit(jacobian)
        if self._before is None:
            self._before = np.zeros(len(step))
        self._before = _displacement(
            step,
            residual,
            jacobian,
            self._before,
            scale,
            self._gain,
            self._speed,
            self._acceleration,
            self._period,
            self._measure,
            self._factors,
        )
        if math.isnan(self._before.item(0)):
            require_finite(step, f"the step of {self._name}")
        return Level(self._name, jacobian, self._before)


@compiled_once
def _unit(gradient: Floats) -> tuple[Floats, float]:
    """A scalar potential's gradient (1, n) made a unit vector, and what its coordinate scales by.

    What the joints do is the same. But the unit of a row says nothing about how near it is to
    losing its influence, and the law would take a short gradient for a singularity and damp it.
    """
    length = _norm(gradient.ravel())
    return (gradient / length, 1.0 / length) if length > 0.0 else (gradient, 0.0)


@compiled_once
def _displacement(
    step: Floats,
    residual: Floats,
    jacobian: Floats,
    before: Floats,
    scale: float,
    gain: float,
    speed: float,
    acceleration: float,
    period: float,
    measure: int,
    factors: int,
) -> Floats:
    """What a task moves by in a tick, shape (k,); NaN where a step is not finite.

    Args:
        step: of an evaluation, shape (k,).
        residual: of the same, shape (k,).
        jacobian: of the level, shape (k, n).
        before: what the task moved by in the tick before, shape (k,).
        scale: of the level's coordinates per coordinate of the evaluation.
        gain: 1/s.
        speed: bound of the rate; infinite for none.
        acceleration: bound of the rate's change; infinite for none.
        period: of the ticks, s.
        measure: what the speed bounds: the norm, the largest component, or the joints' speed.
        factors: parts of the task that are bounded by themselves where the joints' speed is.
    """
    if not math.isfinite(np.sum(step)):
        return np.full(len(step), np.nan)
    rate = scale * gain * step
    if acceleration < math.inf:
        _brake(rate, scale * _norm(residual), acceleration)
    if speed < math.inf:
        size = len(rate) // factors
        for start in range(0, len(rate), size):
            part, most = rate[start : start + size], speed
            if measure == _JOINTS:
                most *= _norm(jacobian[start : start + size].ravel())
            length = np.max(np.abs(part)) if measure == _LARGEST else _norm(part)
            _shorten(part, length, most)
    if acceleration < math.inf:
        last = before / period
        rate -= last
        _shorten(rate, _norm(rate), acceleration * period)
        rate += last
    return rate * period


@compiled
def _brake(rate: Floats, distance: float, acceleration: float) -> None:
    """Make a rate no faster than what ``acceleration`` can still stop within the distance.

    A rate proportional to the distance d, k d, decelerates by k^2 d. Where that is too much, the
    square root of 2 a (d - a / (2 k^2)) joins it smoothly and decelerates by a.
    """
    speed = _norm(rate)
    if distance > 0.0 and speed * speed > acceleration * distance:
        gain = speed / distance
        most = math.sqrt(2.0 * acceleration * (distance - acceleration / (2.0 * gain**2)))
        _shorten(rate, speed, most)


@compiled
def _shorten(vector: Floats, length: float, most: float) -> None:
    """Make a vector, whose length is ``length``, no longer than ``most``."""
    if length > most:
        vector *= most / length


@compiled
def _norm(vector: Floats) -> float:
    total = 0.0
    for component in vector:
        total += component * component
    return math.sqrt(total)

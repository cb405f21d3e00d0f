"""One controller's wish in one tick: from an evaluation to a level of the law."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cbdsl.control.law import Level
from cbdsl.control.potential import Evaluation
from cbdsl.control.signal import Floats, require_finite
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS

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
        self._speed = controller.speed
        self._acceleration = controller.acceleration
        self._kind = controller.feedback.type
        forces = self._kind.name in _FORCES
        potential = POTENTIALS[controller.potential]
        self._is_scalar = not potential.residual and not potential.field
        self._by_joints = forces or self._is_scalar
        self._factors = self._kind.factors if forces else 1
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Start from rest: the controller was activated."""
        self._rate: Floats | None = None

    def level(self, evaluation: Evaluation) -> Level:
        """The displacement of the task coordinates that is wanted in this tick.

        Raises:
            SignalError: the evaluation is not finite; the message names the controller.
        """
        require_finite(evaluation.step, f"the step of {self._name}")
        if self._is_scalar:
            evaluation = _unit(evaluation)
        rate = self._gain * evaluation.step
        if self._acceleration is not None:
            rate = _braked(rate, evaluation.residual, self._acceleration)
        if self._speed is not None:
            rate = self._within_speed(rate, evaluation.jacobian, self._speed)
        if self._acceleration is not None:
            rate = self._within_acceleration(rate, self._acceleration)
        return Level(self._name, evaluation.jacobian, rate * self._period)

    def _within_speed(self, rate: Floats, jacobian: Floats, speed: float) -> Floats:
        if self._by_joints and self._factors == 1:
            stiffness = math.sqrt(np.vdot(jacobian, jacobian))
            return _shortened(rate, _norm(rate), speed * stiffness)
        if self._by_joints:
            rates = rate.reshape(self._factors, -1)  # (factors, components)
            most = speed * _norms(jacobian.reshape(self._factors, -1))
            shares = np.minimum(1.0, most / np.maximum(_norms(rates), 1e-300))
            bounded: Floats = (rates * shares[:, None]).ravel()
            return bounded
        if self._kind.name == "configuration":
            return _shortened(rate, max(map(abs, rate.tolist())), speed)
        return _shortened(rate, _norm(rate), speed)

    def _within_acceleration(self, rate: Floats, acceleration: float) -> Floats:
        before = np.zeros_like(rate) if self._rate is None else self._rate
        change = rate - before
        self._rate = before + _shortened(change, _norm(change), acceleration * self._period)
        return self._rate


def _unit(evaluation: Evaluation) -> Evaluation:
    """The evaluation of a scalar potential, along its gradient instead of in its own unit.

    What the joints do is the same. But the unit of a row says nothing about how near it is to
    losing its influence, and the law would take a short gradient for a singularity and damp it.
    """
    length = _norm(evaluation.jacobian[0])
    if length == 0.0:
        return replace(evaluation, step=np.zeros_like(evaluation.step))
    return Evaluation(
        evaluation.phi,
        evaluation.residual / length,
        evaluation.jacobian / length,
        evaluation.step / length,
    )


def _norm(vector: Floats) -> float:
    return math.sqrt(vector.dot(vector))


def _norms(rows: Floats) -> Floats:
    norms: Floats = np.sqrt((rows * rows).sum(axis=1))
    return norms


def _shortened(vector: Floats, length: float, most: float) -> Floats:
    """``vector``, whose length is ``length``, made no longer than ``most``."""
    return vector if length <= most else vector * (most / length)


def _braked(rate: Floats, residual: Floats, acceleration: float) -> Floats:
    """``rate`` made no faster than what ``acceleration`` can still stop within the residual.

    A rate proportional to the distance d, k d, decelerates by k^2 d. Where that is too much, the
    square root of 2 a (d - a / (2 k^2)) joins it smoothly and decelerates by a.
    """
    distance, speed = _norm(residual), _norm(rate)
    if distance == 0.0 or speed * speed <= acceleration * distance:
        return rate
    gain = speed / distance
    return _shortened(
        rate, speed, math.sqrt(2 * acceleration * (distance - acceleration / (2 * gain**2)))
    )

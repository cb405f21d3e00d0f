"""Rate of task coordinates: gain, speed and acceleration; compiled."""

# Model: a task is a point that follows the gradient of its potential with a bounded rate and a
# bounded change of the rate, like a double integrator under time-discrete control.
# Equations: the rate of the step s is v = kappa s. It is then limited in this order:
#     braking       |v| <= sqrt(2 a (d - a / (2 k^2))), with the residual d and k = |v| / d
#     speed         |v| <= v_max, in the norm of the type of the feedback
#     acceleration  |v - v_before / T| <= a T, with the period T of the ticks
# The displacement of the tick is v T. A Newton step of a spring is half of its residual, so that
# kappa <= 2 / T reaches the reference within one tick and never overshoots it.
# Assumptions: the reference is constant within a tick, and the level achieves its displacement.
# Source: Eq 3.18 for the Newton step; the bounds are additions of this project.

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import add, copy, dot, norm, scale
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS

# Measures that a speed bounds.
_NORM, _LARGEST, _JOINTS = 0.0, 1.0, 2.0

#: Types of feedbacks that joints change by pressing.
FORCES = frozenset({"force", "torque", "wrench"})


class _Bounds(NamedTuple):
    """Gain and bounds of a controller, as numbers of one type.

    Attributes:
        gain: Gain, 1/s.
        speed: Bound of the rate; infinite for none.
        acceleration: Bound of the rate's change; infinite for none.
        period: Period of the ticks, s.
        measure: Bounded quantity: the norm, the largest component, or the joints' speed.
        factors: Number of parts of the task that are bounded separately under a bound of joint
            speed.
    """

    gain: float
    speed: float
    acceleration: float
    period: float
    measure: float
    factors: float


def bounds_of(controller: Controller, period: float) -> Floats:
    """Return gain and bounds of a controller in the form of ``displace``.

    The speed bounds the largest component of a configuration, in rad/s, and the norm of any other
    type. Forces, and potentials without a residual, move only as fast as the joints that move them.
    Their speed is one of the joints, rad/s, and bounds every force of a product separately. Or it
    is one of the tip, m/s, whose force changes by a stiffness. No gain takes a residual past 0
    within a tick, however long the backend's ticks are.

    Args:
        controller: Controller with gain, speed, acceleration and the type of the feedback.
        period: Period of the control ticks, s.
    """
    kind, speed, acceleration = controller.task, controller.speed, controller.acceleration
    potential, forces = POTENTIALS[controller.potential], kind.name in FORCES
    measure = _LARGEST if kind.name == "configuration" else _NORM
    if forces or potential.scalar:
        measure = _JOINTS
    if controller.tip_stiffness is not None and speed is not None:
        measure, speed = _NORM, speed * controller.tip_stiffness
    # A Newton step is half the residual.
    arriving = 2.0 / period
    bounds = _Bounds(
        min(controller.gain, arriving) if potential.residual else controller.gain,
        math.inf if speed is None else speed,
        math.inf if acceleration is None else acceleration,
        period,
        measure,
        kind.factors if forces else 1,
    )
    return np.array(bounds, dtype=np.float64)


@compiled_once
def displace(
    step: Floats, residual: Floats, jacobian: Floats, unit: float, bounds: Floats, before: Floats
) -> bool:
    """Advance a task's displacement from the preceding tick to this one.

    Args:
        step: Step of an evaluation, for a gain of 1, shape (k,); is overwritten.
        residual: Residual of the same evaluation, shape (k,).
        jacobian: Jacobian of the level, shape (k, n).
        unit: Unit of the level's coordinates per coordinate of the evaluation.
        bounds: Gain and bounds from ``bounds_of``.
        before: Displacement of the task coordinates in the preceding tick, shape (k,); becomes this
            tick's.

    Returns:
        True if the step was finite; otherwise ``before`` is unchanged.
    """
    gain, speed, acceleration, period = bounds[0], bounds[1], bounds[2], bounds[3]
    scale(step, unit * gain)
    if not math.isfinite(norm(step)):
        return False
    if acceleration < math.inf:
        _brake(step, unit * norm(residual), acceleration)
    if speed < math.inf:
        _bound_speed(step, jacobian, speed, bounds[4], int(bounds[5]))
    if acceleration < math.inf:
        add(step, before, -1.0 / period)
        _shorten(step, norm(step), acceleration * period)
        add(step, before, 1.0 / period)
    copy(before, step, period)
    return True


@compiled
def brake_before(room: float, bounds: Floats) -> float:
    """Return the part of a way that a task may go in a tick so that it can stop at its end.

    Args:
        room: Way to a bound, in the task's unit; negative beyond the bound, from which the task
            returns by half.
        bounds: Gain and bounds from ``bounds_of``.
    """
    acceleration, period = bounds[2], bounds[3]
    if room <= 0.0:
        return 0.5 * room
    if acceleration < math.inf:
        rate = np.full(1, room / period)
        _brake(rate, room, acceleration)
        room = min(room, rate[0] * period)
    return room


@compiled
def _bound_speed(
    rate: Floats, jacobian: Floats, speed: float, measure: float, factors: int
) -> None:
    """Make a rate (k,) no faster than a speed, separately for each of its factors."""
    size = len(rate) // factors
    for start in range(0, len(rate), size):
        part, most = rate[start : start + size], speed
        if measure == _JOINTS:
            square = 0.0
            for i in range(start, start + size):
                square += dot(jacobian[i], jacobian[i])
            most *= math.sqrt(square)
        length = norm(part)
        if measure == _LARGEST:
            length = 0.0
            for i in range(size):
                length = max(length, abs(part[i]))
        _shorten(part, length, most)


@compiled
def _brake(rate: Floats, distance: float, acceleration: float) -> None:
    """Limit a rate so that ``acceleration`` can still stop it within the distance.

    A rate proportional to the distance d, k d, decelerates by k^2 d. If that is too much, the
    square root of 2 a (d - a / (2 k^2)) joins it smoothly and decelerates by a.
    """
    speed = norm(rate)
    if distance > 0.0 and speed * speed > acceleration * distance:
        gain = speed / distance
        most = math.sqrt(2.0 * acceleration * (distance - acceleration / (2.0 * gain**2)))
        _shorten(rate, speed, most)


@compiled
def _shorten(vector: Floats, length: float, most: float) -> None:
    """Make a vector, whose length is ``length``, no longer than ``most``."""
    if length > most:
        scale(vector, most / length)

"""How fast task coordinates move: gain, speed and acceleration; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.control.signal import Floats
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import add, copy, dot, norm, scale
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS

# The measure that a speed bounds.
_NORM, _LARGEST, _JOINTS = 0.0, 1.0, 2.0

_FORCES = frozenset({"force", "torque", "wrench"})


class _Bounds(NamedTuple):
    """The gain and bounds of a controller, as numbers of one kind.

    Attributes:
        gain: 1/s.
        speed: bound of the rate; infinite for none.
        acceleration: bound of the rate's change; infinite for none.
        period: of the ticks, s.
        measure: that the speed bounds: the norm, the largest component, or the joints' speed.
        factors: parts of the task that are bounded by themselves where the joints' speed is.
    """

    gain: float
    speed: float
    acceleration: float
    period: float
    measure: float
    factors: float


def bounds_of(controller: Controller, period: float) -> Floats:
    """Gain and bounds of a controller, as ``displace`` takes them.

    The speed bounds the largest component of a configuration, in rad/s, and the norm of anything
    else. Forces, and potentials without a residual, move only as fast as the joints that move them:
    their speed is one of the joints, rad/s, and bounds every force of a product by itself; or it is
    one of the tip, m/s, whose force changes by a stiffness. No gain
    takes a residual past 0 within a tick, however long the backend's ticks are.

    Args:
        controller: gives gain, speed, acceleration and the type of the feedback.
        period: of the control ticks, s.
    """
    kind, speed, acceleration = controller.task, controller.speed, controller.acceleration
    potential, forces = POTENTIALS[controller.potential], kind.name in _FORCES
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
    """Advance a task's displacement from the tick before to this one.

    Args:
        step: of an evaluation, for a gain of 1, shape (k,); is used up.
        residual: of the same, shape (k,).
        jacobian: of the level, shape (k, n).
        unit: of the level's coordinates per coordinate of the evaluation.
        bounds: see ``bounds_of``.
        before: displacement of the task coordinates, shape (k,).

    Returns:
        Whether the step was finite; otherwise ``before`` has not changed.
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
def _bound_speed(
    rate: Floats, jacobian: Floats, speed: float, measure: float, factors: int
) -> None:
    """Make a rate (k,) no faster than a speed, each of its factors by itself."""
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
    """Make a rate no faster than what ``acceleration`` can still stop within the distance.

    A rate proportional to the distance d, k d, decelerates by k^2 d. Where that is too much, the
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

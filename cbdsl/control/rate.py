"""How fast task coordinates move: gain, speed and acceleration; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.control.signal import Floats
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.program.controller import Controller
from cbdsl.types.potential import POTENTIALS

# What a speed bounds.
_NORM, _LARGEST, _JOINTS = 0.0, 1.0, 2.0

_FORCES = frozenset({"force", "torque", "wrench"})


class _Bounds(NamedTuple):
    """What ``displace`` wants to know of a controller, as numbers of one kind.

    Attributes:
        gain: 1/s.
        speed: bound of the rate; infinite for none.
        acceleration: bound of the rate's change; infinite for none.
        period: of the ticks, s.
        measure: what the speed bounds: the norm, the largest component, or the joints' speed.
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
    their speed is one of the joints, rad/s, and bounds every force of a product by itself. No gain
    takes a residual past 0 within a tick, however long the backend's ticks are.

    Args:
        controller: gives gain, speed, acceleration and the type of the feedback.
        period: of the control ticks, s.
    """
    kind, speed, acceleration = controller.feedback.type, controller.speed, controller.acceleration
    potential, forces = POTENTIALS[controller.potential], kind.name in _FORCES
    measure = _LARGEST if kind.name == "configuration" else _NORM
    if forces or potential.scalar:
        measure = _JOINTS
    # A Newton step is half the residual.
    arriving = 2.0 / period
    found = _Bounds(
        min(controller.gain, arriving) if potential.residual else controller.gain,
        math.inf if speed is None else speed,
        math.inf if acceleration is None else acceleration,
        period,
        measure,
        kind.factors if forces else 1,
    )
    return np.array(found, dtype=np.float64)


@compiled_once
def displace(
    step: Floats, residual: Floats, jacobian: Floats, scale: float, bounds: Floats, before: Floats
) -> bool:
    """Make what a task moved by in the tick before what it moves by in this one.

    Args:
        step: of an evaluation, shape (k,).
        residual: of the same, shape (k,).
        jacobian: of the level, shape (k, n).
        scale: of the level's coordinates per coordinate of the evaluation.
        bounds: see ``bounds_of``.
        before: displacement of the task coordinates, shape (k,).

    Returns:
        Whether the step was finite; otherwise nothing has changed.
    """
    gain, speed, acceleration, period, measure, factors = bounds
    if not math.isfinite(np.sum(step)):
        return False
    rate = scale * gain * step
    if acceleration < math.inf:
        _brake(rate, scale * norm(residual), acceleration)
    if speed < math.inf:
        size = len(rate) // int(factors)
        for start in range(0, len(rate), size):
            part, most = rate[start : start + size], speed
            if measure == _JOINTS:
                most *= norm(jacobian[start : start + size].ravel())
            length = np.max(np.abs(part)) if measure == _LARGEST else norm(part)
            _shorten(part, length, most)
    if acceleration < math.inf:
        last = before / period
        rate -= last
        _shorten(rate, norm(rate), acceleration * period)
        rate += last
    before[:] = rate * period
    return True


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
        vector *= most / length


@compiled
def norm(vector: Floats) -> float:
    """Its length."""
    total = 0.0
    for component in vector:
        total += component * component
    return math.sqrt(total)

"""Four-valued state of a controller (Eq 4.1)."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.types.state import Predicate

PREDICATES = tuple(Predicate)
_INACTIVE, _UNDEFINED, _TRANSIENT, _QUIESCENT = range(4)

# Notes: the predicate, ticks since the potential is defined, position of the oldest value, number
# of values, newest measurement, and capacity.
PREDICATE, _TICKS, _OLDEST, _KEPT, _STAMP, ROOM = range(6)


def settings_of(rate: float, window: float, period: float) -> Floats:
    """Return the window, s, the largest range in it at rest, and the period, s, shape (3,).

    Rest is judged by the range of the potential over a window, because its derivative at an instant
    flips with every ripple of the signal. Only measured values count: a potential that is repeated
    between two camera images is not at rest for that reason. Time passes with every tick. The range
    that flips of the encoders by one step explain is allowed: that is large where others hold a
    controller far from its target.

    Args:
        rate: Largest range per second at rest, in the potential's unit per second (epsilon).
        window: Duration of observation, s; rest requires a full window.
        period: Period of the ticks, s.

    Raises:
        ValueError: If ``rate``, ``window`` or ``period`` is not positive.
    """
    if not (rate > 0 and window > 0 and period > 0):
        raise ValueError(f"rate {rate}, window {window} and period {period} must be positive")
    return np.array((window, rate * window, period))


def room_of(settings: Floats) -> int:
    """Return the size of a window's ring buffer of pairs: time, s, and potential."""
    # One value is at least as old as the window, the others are within.
    return 2 * (math.ceil(float(settings[0] / settings[2])) + 2)


@compiled_once
def reset(notes: Integers) -> None:
    """Reset all notes of a deactivated controller."""
    notes[PREDICATE] = _INACTIVE
    notes[_TICKS] = notes[_OLDEST] = notes[_KEPT] = 0
    notes[_STAMP] = -1


def restart(notes: Integers) -> None:
    """Restart the window, so that a controller at rest has to rest for another window."""
    notes[_OLDEST] = notes[_KEPT] = 0
    if notes[PREDICATE] == _QUIESCENT:
        notes[PREDICATE] = _TRANSIENT


@compiled_once
def note(
    phi: float, ripple: float, stamp: int, settings: Floats, values: Floats, notes: Integers
) -> None:
    """Note a potential in one tick.

    Args:
        phi: Value of the potential.
        ripple: Change of phi that encoders do not resolve; a range of that size is rest.
        stamp: Stamp of the measurement that phi is based on; an old stamp changes nothing.
        settings: Settings from ``settings_of``.
        values: Ring buffer of the window, shape (``room_of``,).
        notes: Predicate and state of the window, shape (6,).
    """
    notes[_TICKS] += 1
    if stamp != notes[_STAMP]:
        notes[_STAMP] = stamp
        rests = _rests(phi, ripple, notes[_TICKS] * settings[2], settings, values, notes)
        notes[PREDICATE] = _QUIESCENT if rests else _TRANSIENT
    elif notes[PREDICATE] != _QUIESCENT:
        notes[PREDICATE] = _TRANSIENT


@compiled_once
def require_settled(error: float, bound: float, notes: Integers) -> None:
    """Treat a potential that rests too far from its goal as transient.

    Args:
        error: Norm of the residual, in the unit of the feedback.
        bound: Largest error that counts as at rest, in the same unit.
        notes: Notes of ``note``.
    """
    if notes[PREDICATE] == _QUIESCENT and not error <= bound:
        notes[PREDICATE] = _TRANSIENT


@compiled_once
def note_undefined(notes: Integers) -> None:
    """Note that a potential cannot be computed."""
    notes[PREDICATE] = _UNDEFINED
    notes[_TICKS] = notes[_OLDEST] = notes[_KEPT] = 0


@compiled
def _rests(
    phi: float, ripple: float, time: float, settings: Floats, values: Floats, notes: Integers
) -> bool:
    """Store a potential and its time of measurement, s; return whether it is at rest."""
    window, largest_range, _ = settings
    length = len(values)
    newest = (notes[_OLDEST] + 2 * notes[_KEPT]) % length
    values[newest], values[newest + 1] = time, phi
    notes[_KEPT] += 1
    # Keep one value that is as old as the window, so that the rest spans all of it. The tolerance
    # allows for rounding of the summed ticks.
    start = time - window * (1.0 - 1e-9)
    while notes[_KEPT] > 1 and values[(notes[_OLDEST] + 2) % length] <= start:
        notes[_OLDEST] = (notes[_OLDEST] + 2) % length
        notes[_KEPT] -= 1
    if values[notes[_OLDEST]] > start:
        return False
    least = most = phi
    for i in range(notes[_KEPT]):
        value = values[(notes[_OLDEST] + 2 * i) % length + 1]
        least, most = min(least, value), max(most, value)
    rests: bool = most - least <= largest_range + ripple
    return rests

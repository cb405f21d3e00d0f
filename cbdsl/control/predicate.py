"""The four-valued state of a controller (Eq 4.1)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.types.state import Predicate

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


PREDICATES = tuple(Predicate)
_INACTIVE, _UNDEFINED, _TRANSIENT, _QUIESCENT = range(4)

# Notes: the predicate, ticks since the potential is defined, where the oldest value
# is, how many values there are, the newest measurement, and how many numbers there is room for.
PREDICATE, _TICKS, _OLDEST, _KEPT, _STAMP, ROOM = range(6)


def settings_of(rate: float, window: float, period: float) -> Floats:
    """The window, s, the largest range in it at rest, and the period, s, shape (3,).

    A potential is at rest by its range over a window, not by its derivative at an instant, since
    the latter flips with every ripple of the signal. Only measured values enter it: a potential
    that is repeated between two camera images is not at rest for that. Time passes with every tick
    all the same.

    Args:
        rate: largest range per second at rest, in the potential's unit per second (epsilon).
        window: how long the potential is watched, s; at rest needs a window that is full.
        period: time between ticks, s.

    Raises:
        ValueError: ``rate``, ``window`` or ``period`` is not positive.
    """
    if not (rate > 0 and window > 0 and period > 0):
        raise ValueError(f"rate {rate}, window {window} and period {period} must be positive")
    return np.array((window, rate * window, period))


def room_of(settings: Floats) -> int:
    """How many numbers a window keeps: times, s, in front of their potentials, round and round."""
    # One value is as old as the window or older, the others are within.
    return 2 * (math.ceil(float(settings[0] / settings[2])) + 2)


@compiled_once
def reset(notes: Integers) -> None:
    """Forget everything: the controller was deactivated."""
    notes[PREDICATE] = _INACTIVE
    notes[_TICKS] = notes[_OLDEST] = notes[_KEPT] = 0
    notes[_STAMP] = -1


def restart(notes: Integers) -> None:
    """Begin the window anew: what was at rest is not until it has rested for another one."""
    notes[_OLDEST] = notes[_KEPT] = 0
    if notes[PREDICATE] == _QUIESCENT:
        notes[PREDICATE] = _TRANSIENT


@compiled_once
def note(phi: float, stamp: int, settings: Floats, values: Floats, notes: Integers) -> None:
    """Note a potential in one tick.

    Args:
        phi: the potential.
        stamp: of the measurement that phi rests on; one that is not new changes nothing.
        settings: as of ``settings_of``.
        values: the window, shape (``room_of``,).
        notes: the predicate and what else is known, shape (6,).
    """
    notes[_TICKS] += 1
    if stamp != notes[_STAMP]:
        notes[_STAMP] = stamp
        rests = _rests(phi, notes[_TICKS] * settings[2], settings, values, notes)
        notes[PREDICATE] = _QUIESCENT if rests else _TRANSIENT
    elif notes[PREDICATE] != _QUIESCENT:
        notes[PREDICATE] = _TRANSIENT


@compiled_once
def require_settled(error: float, bound: float, notes: Integers) -> None:
    """Take a potential that rests farther from its goal than it may for one on its way.

    Args:
        error: norm of the residual, in the unit of the feedback.
        bound: largest error that counts as at rest, in the same unit.
        notes: as of ``note``.
    """
    if notes[PREDICATE] == _QUIESCENT and not error <= bound:
        notes[PREDICATE] = _TRANSIENT


@compiled_once
def note_undefined(notes: Integers) -> None:
    """Note that a potential cannot be computed."""
    notes[PREDICATE] = _UNDEFINED
    notes[_TICKS] = notes[_OLDEST] = notes[_KEPT] = 0


@compiled
def _rests(phi: float, time: float, settings: Floats, values: Floats, notes: Integers) -> bool:
    """Keep a potential and when it was measured, s; returns whether it is at rest."""
    window, largest_range, _ = settings
    length = len(values)
    newest = (notes[_OLDEST] + 2 * notes[_KEPT]) % length
    values[newest], values[newest + 1] = time, phi
    notes[_KEPT] += 1
    # Keep one value that is as old as the window, so that the rest spans all of it. Ticks add up
    # to a window but for rounding.
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
    rests: bool = most - least <= largest_range
    return rests

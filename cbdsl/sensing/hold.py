"""Rigid holds: how things in the hands move with them (Eq 3.42 and 3.43)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.forward import place_point
from cbdsl.sensing.kinematics import Point
from cbdsl.sensing.memory import PositionMemory

Floats = NDArray[np.float64]

Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

# What is remembered may be off by this much, m.
_OFF = 0.03
# What is painted on a thing is nearer to its middle than its radius and this, m.
_PART = 0.01


class Hold(NamedTuple):
    """The place of the hands that hold something.

    A thing that one hand holds turns with it. One that several hands hold moves as far as all of
    their tips do and does not turn, since they keep facing each other: a hand that goes on alone
    slips along it.

    Attributes:
        hands: a bit for each hand that holds.
        position: of the tip, or the mean of several, m, world frame, shape (3,).
        rotation: of the one tip, or the identity, shape (3, 3).
        tips: of all hands that hold, m, world frame, shape (k, 3).
    """

    hands: int
    position: Floats
    rotation: Floats
    tips: Floats

    def displace(self, begun: Hold, before: Hold, position: Floats) -> Floats:
        """The displacement of a thing that is held, m, shape (3,).

        Args:
            begun: the hold when these hands had taken it.
            before: the hold in the tick before.
            position: of the thing then, m, world frame, shape (3,).
        """
        if len(self.tips) > 1:
            # Since it began: of tremors nothing would be common from tick to tick.
            return _common(self.tips - begun.tips) - _common(before.tips - begun.tips)
        own = before.rotation.T.dot(position - before.position)
        displacement: Floats = self.position + self.rotation.dot(own) - position
        return displacement


def _common(displacements: Floats) -> Floats:
    """How far all of some displacements, shape (k, 3), lead along each axis, shape (3,)."""
    least: Floats = np.maximum(displacements.min(axis=0), 0.0)
    most: Floats = np.minimum(displacements.max(axis=0), 0.0)
    return least + most


class Content:
    """The things that a hold has taken, as decided when it begins: those between the fingers.

    What the hands come near later is not held. A thing that is first seen later is decided on then.

    Args:
        middle: finds the middle between the fingertips that touch, m, world frame, shape (3,).
    """

    def __init__(self, middle: Callable[[], Floats]) -> None:
        self._middle = middle
        #: By thing, since when it is remembered, and whether it is held.
        self._decided: dict[PositionMemory, tuple[float, bool]] = {}

    def begin(self, memories: Iterable[PositionMemory]) -> None:
        """Decide which of all things are held."""
        self._decided.clear()
        middle = self._middle()
        places = {m: m.position for m in memories if m.position is not None}
        depths = {m: math.dist(middle, place) - m.radius for m, place in places.items()}
        for memory in sorted(places, key=lambda m: depths[m]):
            self.holds(memory)

    def holds(self, memory: PositionMemory) -> bool:
        """Whether a thing is held; see ``begin``."""
        if memory.position is None:
            return False
        since, is_held = self._decided.get(memory, (None, False))
        if since != memory.since:
            is_held = self._is_between(memory.position, memory.radius)
            self._decided[memory] = memory.since, is_held
        return is_held

    def _is_between(self, position: Floats, radius: float) -> bool:
        # What was decided of a thing before it was lost says nothing of where it is seen again.
        held = [
            (memory.position, memory.radius)
            for memory, (since, is_held) in self._decided.items()
            if is_held and since == memory.since and memory.position is not None
        ]
        if not held:
            return math.dist(self._middle(), position) <= radius + _OFF
        # Two channels may show one thing, or one of them a part of it.
        return any(math.dist(place, position) <= size + _PART for place, size in held)


def held_jacobian(tips: Sequence[Point], position: Floats) -> Floats:
    """Displacement of a thing per joint, shape (3, n); of several hands' where all go alike.

    Args:
        tips: of the hands that hold it.
        position: of the thing, m, world frame, shape (3,).
    """
    if len(tips) > 1:
        mean: Floats = np.mean([tip.jacobian[:3] for tip in tips], axis=0)
        return mean
    linear, angular = tips[0].jacobian[:3], tips[0].jacobian[3:]
    x, y, z = (position - tips[0].position).tolist()
    across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    jacobian: Floats = linear + across.dot(angular)
    return jacobian


@compiled_once
def find_hold(
    frames: Floats,
    carriers: NDArray[Any],
    cells: Integers,
    feeling: Booleans,
    position: Floats,
    rotation: Floats,
) -> int:
    """Find the hands that hold: one with all of its fingers, or several that feel contact.

    Args:
        frames: of the kinematics.
        carriers: the hands' tips, shape (hands,) of ``refresh.PART``.
        cells: the first load cell of each hand and the one after its last, shape (hands, 2).
        feeling: whether each load cell is in contact, shape (cells,).
        position: becomes the tip's, or the mean of several, m, shape (3,).
        rotation: becomes the one tip's, or the identity, shape (3, 3).

    Returns:
        A bit for each hand that holds; 0 for none.
    """
    point, hands, number, last = np.empty(3), 0, 0, 0
    position[:] = 0.0
    for hand in range(len(carriers)):
        if not feeling[cells[hand, 0] : cells[hand, 1]].any():
            continue
        place_point(frames[carriers[hand].frame], carriers[hand].origin, point)
        for i in range(3):
            position[i] += point[i]
        hands, number, last = hands | (1 << hand), number + 1, hand
    if number == 0 or (number == 1 and not feeling[cells[last, 0] : cells[last, 1]].all()):
        # A finger that brushes against a thing pushes it away, and does not take it along.
        return 0
    frame, turned = frames[carriers[last].frame], carriers[last].rotation
    for i in range(3):
        position[i] /= number
        for k in range(3):
            rotation[i, k] = 1.0 if i == k else 0.0
            if number == 1:
                rotation[i, k] = 0.0
                for inner in range(3):
                    rotation[i, k] += frame[3 * i + inner] * turned[3 * inner + k]
    return hands

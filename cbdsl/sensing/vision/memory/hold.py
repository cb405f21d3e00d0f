"""Rigid holds: motion of held objects with the hands (Eq 3.42 and 3.43)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.kinematics.forward import place_point
from cbdsl.kinematics.kinematics import Point
from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.vision.memory.memory import PositionMemory

# Largest error of a remembered position, m.
_OFF = 0.03
# A mark on an object is nearer to the object's middle than its radius plus this distance, m.
_PART = 0.01


class Hold(NamedTuple):
    """Placement of the hands that hold an object.

    An object that one hand holds turns with it. An object that several hands hold moves by the
    displacement common to all of their tips. It does not turn, because the hands keep facing each
    other. A hand that continues alone slips along it.

    Attributes:
        hands: Bit mask of the hands that hold.
        position: Position of the tip, or the mean of several, m, world frame, shape (3,).
        rotation: Rotation of the one tip, or the identity, shape (3, 3).
        tips: Tip positions of all hands that hold, m, world frame, shape (k, 3).
    """

    hands: int
    position: Floats
    rotation: Floats
    tips: Floats

    def displace(self, begun: Hold, before: Hold, position: Floats) -> Floats:
        """Return the displacement of a held object since the previous tick, m, shape (3,).

        Args:
            begun: State of the hold at the tick in which these hands took the object.
            before: State of the hold in the previous tick.
            position: Position of the object in that tick, m, world frame, shape (3,).
        """
        if len(self.tips) > 1:
            # Measured since the hold began, because trembling tips share no motion from tick to
            # tick.
            return _common(self.tips - begun.tips) - _common(before.tips - begun.tips)
        # A rigid motion keeps the place of the object in the hand: x' = t' + R' R^T (x - t).
        own = before.rotation.T.dot(position - before.position)
        displacement: Floats = self.position + self.rotation.dot(own) - position
        return displacement


def _common(displacements: Floats) -> Floats:
    """Return the common part of displacements, shape (k, 3), along each axis, shape (3,)."""
    least: Floats = np.maximum(displacements.min(axis=0), 0.0)
    most: Floats = np.minimum(displacements.max(axis=0), 0.0)
    return least + most


class Content:
    """Objects of a hold: those between the fingers when it begins.

    Objects that the hands approach later are not held. An object first seen later is judged then.

    Args:
        middle: Function that returns the middle between the fingertips in contact, m, world frame,
            shape (3,).
    """

    def __init__(self, middle: Callable[[], Floats]) -> None:
        self._middle = middle
        #: Time of discovery and whether the object is held, by object.
        self._decided: dict[PositionMemory, tuple[float, bool]] = {}

    def begin(self, memories: Iterable[PositionMemory]) -> None:
        """Decide for all objects whether they are held."""
        self._decided.clear()
        middle = self._middle()
        places = {m: m.position for m in memories if m.position is not None}
        depths = {m: math.dist(middle, place) - m.radius for m, place in places.items()}
        for memory in sorted(places, key=lambda m: depths[m]):
            self.holds(memory)

    def holds(self, memory: PositionMemory) -> bool:
        """Return whether an object is held; see ``begin``."""
        if memory.position is None:
            return False
        since, is_held = self._decided.get(memory, (None, False))
        if since != memory.since:
            is_held = self._is_between(memory.position, memory.radius)
            self._decided[memory] = memory.since, is_held
        return is_held

    def _is_between(self, position: Floats, radius: float) -> bool:
        # A decision on an object that was lost does not hold for the place of its rediscovery.
        held = [
            (memory.position, memory.radius)
            for memory, (since, is_held) in self._decided.items()
            if is_held and since == memory.since and memory.position is not None
        ]
        if not held:
            return math.dist(self._middle(), position) <= radius + _OFF
        # Two channels may show one object, or one of them a part of it.
        return any(math.dist(place, position) <= size + _PART for place, size in held)


def held_jacobian(tips: Sequence[Point], position: Floats) -> Floats:
    """Return the displacement of a held object per joint, shape (3, n); the mean of several tips.

    Args:
        tips: Tips of the hands that hold the object.
        position: Position of the object, m, world frame, shape (3,).
    """
    if len(tips) > 1:
        mean: Floats = np.mean([tip.jacobian[:3] for tip in tips], axis=0)
        return mean
    linear, angular = tips[0].jacobian[:3], tips[0].jacobian[3:]
    x, y, z = (position - tips[0].position).tolist()
    # With the lever r and the angular velocity w, the velocity is v + w x r. The matrix is minus
    # the cross-product matrix of r, because w x r = -r x w.
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
    """Find the hands that hold: one with all fingers in contact, or several with any contact.

    Args:
        frames: Joint frames of the kinematics.
        carriers: Tips of the hands, shape (hands,) of ``refresh.PART``.
        cells: Numbers of the first load cell of each hand and the one after its last, shape (hands,
            2).
        feeling: True for each load cell in contact, shape (cells,).
        position: Output: position of the tip, or the mean of several, m, shape (3,).
        rotation: Output: rotation of the one tip, or the identity, shape (3, 3).

    Returns:
        Bit mask of the hands that hold; 0 for none.
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
        # A single finger in contact pushes an object away and does not hold it.
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

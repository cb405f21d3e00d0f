"""Slip of objects within the hands that carry them, by the simulator's ground truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl import Truth
from cbdsl.api.control import UrdfModel
from cbdsl.api.documents import RobotDocument

Floats = NDArray[np.float64]

# Height above its initial position from which an object counts as carried, m.
_LIFTED = 0.01
# A hand that touches an object with fewer fingertips does not hold it.
_FINGERS = 2


def palms(robot: RobotDocument, model: UrdfModel) -> Mapping[str, str]:
    """Return the link that carries each hand with load cells, by hand: the tip of an arm."""
    tips = {each.tip.link for each in robot.effectors.values() if each.tip is not None}
    carriers = {}
    for hand, fingers in robot.load_cells.items():
        for cell in fingers.values():
            below = [joint.parent for joint in model.way(cell.link) if joint.parent in tips]
            if below:
                carriers[hand] = below[0]
    return carriers


class SlipGauge:
    """Gauge of the slip of objects in hands during an episode.

    An object is carried once it is 1 cm above its initial position, while a hand touches it with
    two fingertips. From then on, each displacement in the hand's frame is slip.

    Args:
        truth: Truth of the simulated world.
        hands: Link whose frame is the hand's frame, by hand.
        fixtures: Names of objects that cannot be carried.
    """

    def __init__(self, truth: Truth, hands: Mapping[str, str], fixtures: frozenset[str]) -> None:
        self._truth, self._hands, self._fixtures = truth, hands, fixtures
        self._heights: dict[str, float] = {}
        self._held: dict[tuple[str, str], Floats] = {}
        #: Largest slip so far, m; ``None`` if no object was carried.
        self.largest: float | None = None

    def watch(self, _: Any) -> None:
        """Measure the slip after a tick."""
        for name in self._truth.objects:
            if name in self._fixtures:
                continue
            place = self._truth.position(name)
            height = self._heights.setdefault(name, float(place[2]))
            carrying = self._carrying(name) if place[2] - height > _LIFTED else frozenset()
            for hand in self._hands:
                if hand in carrying:
                    self._measure(name, hand, place)
                else:
                    # The next grasp begins with a place of its own in the hand.
                    self._held.pop((name, hand), None)

    def _carrying(self, name: str) -> frozenset[str]:
        """Return the hands that touch an object with enough fingertips."""
        touching = [hand for hand, _ in self._truth.touching(name)]
        return frozenset(hand for hand in touching if touching.count(hand) >= _FINGERS)

    def _measure(self, name: str, hand: str, place: Floats) -> None:
        palm = self._hands[hand]
        inside: Floats = self._truth.link_rotation(palm).T @ (
            place - self._truth.link_position(palm)
        )
        first = self._held.setdefault((name, hand), inside)
        self.largest = max(self.largest or 0.0, float(np.linalg.norm(inside - first)))

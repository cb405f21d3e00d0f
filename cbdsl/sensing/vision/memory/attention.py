"""Attention: selection of one object among those of a channel."""

from __future__ import annotations

import math
from functools import partial

from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.memory.object_memories import ObjectMemories
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView


class Attention:
    """Object attended to, which stays the same while it is remembered.

    Args:
        objects: Objects of the channel.
        field: Field of view of the cameras.

    Attributes:
        attended: Number of the object attended to.
    """

    def __init__(self, objects: ObjectMemories, field: FieldOfView) -> None:
        self._objects, self._field = objects, field
        self.reset()

    def reset(self) -> None:
        """Forget the previous episode."""
        self.attended = 0
        self._place: Floats | None = None

    def number(self, instance: str) -> int | None:
        """Return the number of an instance as resources name it, ``None`` while there is none.

        Args:
            instance: One of ``SELECTIONS``, a number in the order of discovery, from 1, or "" for
                the object attended to.
        """
        if not instance:
            return self.attended
        if instance.isdigit():
            return int(instance) - 1
        known = [k for k in self._objects.known if instance != "other" or k != self.attended]
        return min(known, key=partial(self._rank, instance), default=None)

    def _rank(self, selection: str, number: int) -> tuple[float, int]:
        """Return a sorting key that puts the selected instance first."""
        position, radius = self._objects.ball(number)
        if selection == "largest":
            return -radius, number
        if selection == "other":
            place = self._objects.memories[self.attended].position
            return (0.0 if place is None else math.dist(position, place)), number
        offset = position - self._field.middle
        if selection == "nearest":
            return math.hypot(*offset.tolist()), number
        azimuth = math.atan2(offset[1], offset[0])
        return (-azimuth if selection == "leftmost" else azimuth), number

    def update(self) -> None:
        """Keep attention on a remembered object, or move it to the nearest one."""
        if not self._objects.memories:
            return
        if self._objects.memories[self.attended].position is None:
            known = self._objects.known
            if not known:
                return
            self.attended = min(known, key=self._priority)
        self._place = self._objects.memories[self.attended].position

    def _priority(self, number: int) -> tuple[float, float, int]:
        """Return a sorting key: distance from the last place of attention, then largest area."""
        position, place = self._objects.position(number), self._place
        distance = 0.0 if place is None else math.dist(position, place)
        seen = [each[number] for each in self._objects.sightings if number in each]
        return distance, -sum(sighting.region.area for sighting in seen), number

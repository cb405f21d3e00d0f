"""Occlusion: remembered objects that hands or other objects hide from the cameras."""

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.memory.object_memories import ObjectMemories
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView

# A region of another channel that is larger than an object by this factor is behind it.
_BACKGROUND = 5.0


class Occlusion:
    """Objects of one channel that are hidden in the newest images.

    Args:
        objects: Objects of the channel.
        field: Field of view of the cameras.

    Attributes:
        others: Sightings of the other channels' regions in the newest images, by camera.
    """

    def __init__(self, objects: ObjectMemories, field: FieldOfView) -> None:
        self._objects, self._field = objects, field
        self.others: Sequence[Sequence[Sighting]] = ()

    def is_hidden(self, number: int) -> bool:
        """Return whether an object is occluded in every image that would otherwise show it."""
        position, radius = self._objects.ball(number)
        if self._field.is_hidden_by_hand(position):
            return True
        hidden = self.by_others(number)
        if not any(hidden):
            return False
        views = self._field.views(position, radius)
        return all(hides or not view for hides, view in zip(hidden, views, strict=True))

    def may_hide(self, number: int, position: Floats) -> bool:
        """Return whether a hand or another object may occlude a part of an object.

        Args:
            number: Number of the object.
            position: Position at which it is seen now, m, shape (3,).
        """
        if self._field.is_hidden_by_hand(position):
            return True
        is_known = self._objects.memories[number].position is not None
        return is_known and any(self._covered(number))

    def by_others(self, number: int) -> list[bool]:
        """Return for each camera whether other objects occlude an object."""
        others = [self._objects.ball(other) for other in self._objects.known if other != number]
        hidden = self._field.hidden_by(self._objects.ball(number), others)
        return [
            hides or covers for hides, covers in zip(hidden, self._covered(number), strict=True)
        ]

    def _covered(self, number: int) -> list[bool]:
        """Return for each camera whether another channel's region covers an object's middle.

        A much larger region, such as that of a table, is a background and covers nothing.
        """
        position, radius = self._objects.ball(number)
        most = _BACKGROUND * radius
        if not self.others:
            return [False] * len(self._objects.sightings)
        return [
            any(
                sighting.distance(position) < sighting.radius(position) < most
                for sighting in sightings
            )
            for sightings in self.others
        ]

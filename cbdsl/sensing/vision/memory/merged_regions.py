"""Merged regions: regions that show two objects of a channel, or one and a part of another."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from cbdsl.sensing.channels import Region
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.memory.object_memories import ObjectMemories
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView

# Least ratio of the radius of merged regions to that of the known object.
_GROWN = 1.04
# Least share of an object's radius at which a region shows the whole object.
_NEARLY = 0.9
# Two merged round regions have at least this ratio of length to width, and fill less of the ellipse
# with the same moments; a rectangle fills 0.955 of it.
_LONG = 1.3
_FILLED = 0.92
# Two touching discs of any sizes are at most 2.24 times as long as wide. A longer region is one
# slender object, such as a hammer. A straight row of three touching discs is taken for one, too.
_SLENDER = 3.0


class MergedRegions:
    """Sightings of one channel that may show more than one object.

    Args:
        objects: Objects of the channel.
        field: Field of view of the cameras.
    """

    def __init__(self, objects: ObjectMemories, field: FieldOfView) -> None:
        self._objects, self._field = objects, field

    def has_grown_together(self, number: int, known: Sequence[int]) -> bool:
        """Return whether an object's region may also show another object or a part of it.

        The other object either has no region of its own, or a hand leaves only parts of it visible.
        """
        return any(
            self._touches(claims[number], other) and not self._is_seen_whole(claims, other)
            for row, claims in enumerate(self._objects.sightings)
            if number in claims
            for other in known
            if other != number and not self._is_just_before(row, number, other)
        )

    def contain(self, number: int) -> bool:
        """Return whether an object may be a part of another object's region, which has grown."""
        for claims in self._objects.sightings:
            for other, sighting in claims.items():
                memory = self._objects.memories[other]
                if other == number or memory.position is None:
                    continue
                grown = sighting.radius(memory.position) >= _GROWN * memory.radius
                if grown and self._touches(sighting, number):
                    return True
        return False

    def _is_seen_whole(self, claims: Mapping[int, Sighting], number: int) -> bool:
        """Return whether an object has a region of its own of nearly its full size."""
        position, radius = self._objects.ball(number)
        seen = claims.get(number)
        return seen is not None and seen.radius(position) >= _NEARLY * radius

    def _touches(self, sighting: Sighting, other: int) -> bool:
        """Return whether a region reaches the expected image of a remembered object."""
        position, radius = self._objects.ball(other)
        return sighting.distance(position) - radius < sighting.radius(position)

    def _is_just_before(self, row: int, number: int, other: int) -> bool:
        """Return whether a camera sees an object, no larger than it is, in front of another one.

        The result is false for an object that a hand may occlude, because the size of its own part
        of a region is unknown.
        """
        position, radius = self._objects.ball(number)
        if self._field.is_hidden_by_hand(position):
            return False
        sighting = self._objects.sightings[row][number]
        if sighting.radius(position) >= _GROWN * radius:
            return False
        return self._field.hidden_by(self._objects.ball(other), [(position, radius)])[row]


def is_compact(region: Region) -> bool:
    """Return whether a region is a single one, and not two merged round ones."""
    columns, mixed, rows = region.moments
    middle, half = (columns + rows) / 2, math.hypot((columns - rows) / 2, mixed)
    longer, shorter = middle + half, max(middle - half, 0.0)
    ellipse = 4 * math.pi * math.sqrt(longer * shorter)
    merged = _LONG**2 * shorter <= longer < _SLENDER**2 * shorter
    return region.area >= _FILLED * ellipse or not merged

"""Discovery: objects of a channel that the newest images show and no memory explains."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from cbdsl.documents.robot import Regions
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.association.association import Meeting, Pair, pair
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.memory.merged_regions import is_compact
from cbdsl.sensing.vision.memory.object_memories import ObjectMemories
from cbdsl.sensing.vision.memory.occlusion import Occlusion
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView

# A new object beside others is accepted if two successive images show it within this distance, m.
_STEADY = 0.02


class Discovery:
    """Assignment of unclaimed sightings to new objects, or to objects that have moved.

    Args:
        settings: Parameters of regions and memories.
        objects: Objects of the channel.
        field: Field of view of the cameras.
        occlusion: Occlusion of these objects.
    """

    def __init__(
        self, settings: Regions, objects: ObjectMemories, field: FieldOfView, occlusion: Occlusion
    ) -> None:
        self._settings, self._objects = settings, objects
        self._field, self._occlusion = field, occlusion
        self.reset()

    def reset(self) -> None:
        """Forget the images before."""
        self._candidates: list[Floats] = []

    def update(self, time: float, seen: Sequence[Sequence[Sighting]], *, among: bool) -> None:
        """Remember new objects, and offer the largest region that shows none.

        Args:
            time: Current time, s.
            seen: Sightings of the channel's regions by camera.
            among: True if other objects were known before these images.
        """
        left, right = (
            [sighting for sighting in sightings if sighting not in each.values()]
            for each, sightings in zip(self._objects.sightings, seen, strict=True)
        )
        certain, _ = pair(left, right, self._settings)
        fresh = [each for each in certain if self._may_be_another(each, left, right)]
        before, self._candidates = self._candidates, [each.meeting.position for each in fresh]
        for candidate in sorted(fresh, key=lambda candidate: -sum(candidate.meeting.sizes)):
            if not among or _is_near(candidate.meeting.position, before):
                sightings = left[candidate.left], right[candidate.right]
                self._discover(time, sightings, candidate.meeting)
        self._offer(left, right, certain)

    def _may_be_another(
        self, candidate: Pair, left: Sequence[Sighting], right: Sequence[Sighting]
    ) -> bool:
        """Return whether two sightings show a whole object that is not yet remembered."""
        sightings = left[candidate.left], right[candidate.right]
        if not candidate.whole or not all(is_compact(each.region) for each in sightings):
            return False
        if self._may_be_fragments(sightings):
            return False
        # An object that a hand partly occludes looks too small. It would seem to move as the hand
        # leaves.
        if self._field.is_hidden_by_hand(candidate.meeting.position):
            return False
        radius = math.sqrt(max(candidate.meeting.sizes) / math.pi)
        balls = map(self._objects.ball, self._objects.known)
        return all(
            math.dist(position, candidate.meeting.position) > max(own, radius)
            for position, own in balls
        )

    def _may_be_fragments(self, sightings: Sequence[Sighting]) -> bool:
        """Return whether sightings may be fragments of a remembered object behind a hand.

        Two cameras see different parts of it between the fingers. Their lines of sight meet at a
        wrong position.
        """
        return any(
            any(each.distance(position) <= radius for each in sightings)
            and self._field.is_hidden_by_hand(position)
            for position, radius in map(self._objects.ball, self._objects.known)
        )

    def _discover(
        self, time: float, sightings: tuple[Sighting, Sighting], meeting: Meeting
    ) -> None:
        """Remember a new object, or one that has moved, if a number is available."""
        number = next(self._moved(meeting.position), self._objects.free)
        if number is None:
            return
        memory = self._objects.memories[number]
        memory.reset()
        memory.see(time, meeting.position, meeting.sizes)
        for each, sighting in zip(self._objects.sightings, sightings, strict=True):
            each[number] = sighting

    def _moved(self, position: Floats) -> Iterator[int]:
        """Yield objects that are unseen at their place and may have moved to a position."""
        for number in self._objects.known:
            place, radius = self._objects.ball(number)
            if any(number in each for each in self._objects.sightings):
                continue
            if not self._field.shows(place, radius):
                continue
            near = math.dist(place, position) <= self._settings.hand_radius
            if near or not self._occlusion.is_hidden(number):
                yield number

    def _offer(
        self, left: Sequence[Sighting], right: Sequence[Sighting], certain: Sequence[Pair]
    ) -> None:
        """Give the largest region that shows no remembered object the lowest free number.

        This defines headings to an object without a position, which one camera does not see or sees
        partly. Its counterpart in the other image gets the same number.
        """
        free = self._objects.free
        options = [
            (-sighting.region.area, row, number)
            for row, sightings in enumerate((left, right))
            for number, sighting in enumerate(sightings)
            if not self._is_part_of_known(sighting)
        ]
        if free is None or not options:
            return
        _, row, number = min(options)
        self._objects.sightings[row][free] = (left, right)[row][number]
        for each in certain:
            numbers = each.left, each.right
            if numbers[row] == number:
                other = 1 - row
                self._objects.sightings[other][free] = (left, right)[other][numbers[other]]

    def _is_part_of_known(self, sighting: Sighting) -> bool:
        """Return whether a line of sight leads to a remembered object."""
        balls = map(self._objects.ball, self._objects.known)
        return any(sighting.distance(position) <= radius for position, radius in balls)


def _is_near(position: Floats, places: Sequence[Floats]) -> bool:
    return any(math.dist(position, place) <= _STEADY for place in places)

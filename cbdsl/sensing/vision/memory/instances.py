"""Instances: objects of one channel, distinguished and remembered individually."""

# Model: each object of a channel is a ball with a remembered position and radius. Each image
# assigns regions to objects, and the rest of the regions to new objects. Steps for one image pair:
#     1. claim    each object takes the region nearest to its line of sight, within radius + BESIDE
#     2. retract  a claim by one camera is dropped if the other should see the object and does not
#     3. grow     a claim that may show two objects, or a part of another one, is not believed
#     4. update   positions of the other claims correct the memories; missing ones are explained
#     5. discover stereo matches of the other regions in two successive images are new objects
# Assumptions: objects of one channel look alike, so that only position and size distinguish them.
# They move less between two images than the distance to their neighbours, or a hand carries them. A
# missing object is kept if a hand, another object, or the border of the view explains its absence.
# It is forgotten otherwise, because a robot that acts on a removed object acts on nothing.
# Source: Eq 3.10 has one object per channel; several instances are an addition of this project.

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.documents.robot import Regions
from cbdsl.sensing.vision.association.association import Meeting, meet
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.memory.attention import Attention
from cbdsl.sensing.vision.memory.discovery import Discovery
from cbdsl.sensing.vision.memory.memory import BESIDE
from cbdsl.sensing.vision.memory.merged_regions import MergedRegions, is_compact
from cbdsl.sensing.vision.memory.object_memories import ObjectMemories
from cbdsl.sensing.vision.memory.occlusion import Occlusion
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView

Sightings = Sequence[Sequence[Sighting]]


class Instances:
    """Objects of one channel in the order of discovery, one of which is attended to.

    An object keeps its number while it is remembered; a new one takes the lowest free number.
    Attention is first on the object with the largest image. It stays on an object while that is
    remembered, and then moves to the nearest of the others.

    Args:
        settings: Number of distinguished objects, and parameters of their memories.
        field: Field of view of the cameras.
        cameras: Number of cameras; only two give positions.

    Attributes:
        memories: Memories by number, from 0.
        sightings: Sightings in the newest images, as in ``ObjectMemories``.
        regions: Largest number of regions in one of these images.
    """

    def __init__(self, settings: Regions, field: FieldOfView, cameras: int) -> None:
        self._settings, self._field, self._stereo = settings, field, cameras == 2
        self._objects = ObjectMemories(settings, cameras)
        self.memories, self.sightings = self._objects.memories, self._objects.sightings
        self._attention = Attention(self._objects, field)
        self._occlusion = Occlusion(self._objects, field)
        self._merged = MergedRegions(self._objects, field)
        self._discovery = Discovery(settings, self._objects, field, self._occlusion)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._exposed, self.regions = 0.0, 0
        self._objects.reset()
        self._attention.reset()
        self._occlusion.others = ()
        self._discovery.reset()

    @property
    def attended(self) -> int:
        """Number of the object attended to."""
        return self._attention.attended

    @property
    def known(self) -> list[int]:
        """Numbers of the remembered objects."""
        return self._objects.known

    def number(self, instance: str) -> int | None:
        """Return the number of an instance, ``None`` while there is none; see ``Attention``."""
        return self._attention.number(instance)

    def look(self, time: float, exposed: float, seen: Sightings, others: Sightings = ()) -> None:
        """Update sightings and memories from the newest images.

        Args:
            time: Current time, s.
            exposed: Time of exposure of the images, s.
            seen: Sightings of the channel's regions by camera, the largest first.
            others: Sightings of the other channels' regions by camera.
        """
        self._exposed, self._occlusion.others = exposed, others
        self.regions = max(map(len, seen), default=0)
        self._objects.forget_sightings()
        known = self.known
        if not known:
            self._attention.attended = 0
        if self._is_single_object(seen, known):
            for each, sightings in zip(self.sightings, seen, strict=True):
                if sightings:
                    each[self.attended] = sightings[0]
            if self._stereo:
                self._update_memory(time, self.attended)
        elif self._stereo:
            self._associate_several(time, seen, known)
        else:
            for each, sightings in zip(self.sightings, seen, strict=True):
                each[self.attended] = sightings[0]
        self._attention.update()

    def _is_single_object(self, seen: Sightings, known: Sequence[int]) -> bool:
        """Return whether all sightings may show the one known object, or the first one."""
        if len(known) > 1 or any([len(sightings) > 1 for sightings in seen]):
            return False
        if not known:
            return True
        self._attention.attended = known[0]
        position, radius = self._objects.ball(known[0])
        reach = radius + BESIDE
        if all([each.distance(position) <= reach for one in seen for each in one]):
            return True
        # An unoccluded object away from its remembered position has moved.
        if not self._occlusion.is_hidden(known[0]):
            return self._field.shows(position, radius)
        far = reach + self._settings.hand_radius
        return all([each.distance(position) <= far for one in seen for each in one])

    def _update_memory(self, time: float, number: int, *, believed: bool = True) -> None:
        """Update the memory of one object from the newest images."""
        memory = self.memories[number]
        sighting = self._triangulated(number) if believed else None
        if sighting is not None and (memory.position is not None or self._is_whole(number)):
            position, _, sizes = sighting
            aside = self._distances_of_sight(number)
            if memory.has_shrunk(sizes, aside) and not self._occlusion.may_hide(number, position):
                memory.forget_size(sizes, aside)
            if memory.see(time, position + memory.moved_since(self._exposed), sizes):
                return
        if memory.position is not None:
            memory.miss(time, explained=self._may_remain(time, number))

    def _distances_of_sight(self, number: int) -> list[float]:
        """Return the distances of an object's lines of sight from its remembered position, m."""
        place = self.memories[number].position
        return [0.0 if place is None else each[number].distance(place) for each in self.sightings]

    def _is_whole(self, number: int) -> bool:
        """Return whether the regions of a newly seen object are compact, and so one object."""
        return all(is_compact(each[number].region) for each in self.sightings)

    def _triangulated(self, number: int) -> Meeting | None:
        """Return where both cameras see an object whole, or ``None``."""
        left, right = [each.get(number) for each in self.sightings]
        if left is None or right is None or left.region.clipped or right.region.clipped:
            return None
        meeting = meet(left, right, self._settings.farthest)
        if meeting is None or meeting.gap > self._settings.ray_gap:
            return None
        return meeting

    def _may_remain(self, time: float, number: int) -> bool:
        """Return whether an unseen object may still be at its remembered position."""
        memory = self.memories[number]
        position, radius = self._objects.ball(number)
        if self._occlusion.is_hidden(number):
            return True
        if not self._field.shows(position, radius):
            # The position of an object that moved out of view is unknown.
            return not memory.is_lost(time)
        reach, seen = radius + BESIDE, [each[number] for each in self.sightings if number in each]
        if any(sighting.distance(position) <= reach for sighting in seen):
            return True
        return not memory.is_lost(time) and self._merged.contain(number)

    def _associate_several(self, time: float, seen: Sightings, known: Sequence[int]) -> None:
        """Update from images with several regions, or with an object other than the known one."""
        for each, sightings in zip(self.sightings, seen, strict=True):
            self.associate(each, sightings)
        for number in known:
            self._reject_unconfirmed(number)
        grown = {k for k in known if self._merged.has_grown_together(k, known)}
        for number in known:
            self._update_memory(time, number, believed=number not in grown)
        self._discovery.update(time, seen, among=bool(known))

    def associate(self, associated: dict[int, Sighting], sightings: Sequence[Sighting]) -> None:
        """Assign to each remembered object a sighting that leads to it, the nearest pairs first."""
        options = []
        for number in self.known:
            position, radius = self._objects.ball(number)
            for place, sighting in enumerate(sightings):
                distance = sighting.distance(position)
                if distance <= radius + BESIDE:
                    options.append((distance, number, place))
        taken = set()
        for _, number, place in sorted(options):
            if number not in associated and place not in taken:
                associated[number] = sightings[place]
                taken.add(place)

    def _reject_unconfirmed(self, number: int) -> None:
        """Remove a sighting by one camera if the other should see the object, too, and does not."""
        position, radius = self._objects.ball(number)
        confirmed = [number in each for each in self.sightings]
        if confirmed[0] == confirmed[1] or self._field.is_hidden_by_hand(position):
            return
        other = confirmed.index(False)
        views = self._field.views(position, radius)
        if views[other] and not self._occlusion.by_others(number)[other]:
            del self.sightings[1 - other][number]

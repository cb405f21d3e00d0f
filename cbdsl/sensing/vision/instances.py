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

import math
from collections.abc import Iterator, Sequence
from functools import partial

from cbdsl.documents.robot import Regions
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import Region
from cbdsl.sensing.vision.association import Meeting, Pair, meet, pair
from cbdsl.sensing.vision.field_of_view import FieldOfView
from cbdsl.sensing.vision.memory import BESIDE, PositionMemory
from cbdsl.sensing.vision.sighting import Sighting

Sightings = Sequence[Sequence[Sighting]]

# A new object beside others is accepted if two successive images show it within this distance, m.
_STEADY = 0.02
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
# A region of another channel that is larger than an object by this factor is behind it.
_BACKGROUND = 5.0


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
        attended: Number of the object attended to.
        sightings: Sightings in the newest images, by camera and number of the object. A region that
            shows no remembered object has the lowest free number.
    """

    def __init__(self, settings: Regions, field: FieldOfView, cameras: int) -> None:
        self._settings, self._field, self._cameras = settings, field, cameras
        self._stereo = cameras == 2
        count = settings.instances if self._stereo else 0
        self.memories = tuple(PositionMemory(settings) for _ in range(count))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.attended, self._exposed = 0, 0.0
        self._others: Sightings = ()
        self.sightings: list[dict[int, Sighting]] = [{} for _ in range(self._cameras)]
        self._candidates: list[Floats] = []
        self._place: Floats | None = None
        for memory in self.memories:
            memory.reset()

    @property
    def known(self) -> list[int]:
        """Numbers of the remembered objects."""
        return [k for k, memory in enumerate(self.memories) if memory.position is not None]

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
        known = [k for k in self.known if instance != "other" or k != self.attended]
        return min(known, key=partial(self._rank, instance), default=None)

    def _rank(self, selection: str, number: int) -> tuple[float, int]:
        """Return a sorting key that puts the selected instance first."""
        memory = self.memories[number]
        assert memory.position is not None
        if selection == "largest":
            return -memory.radius, number
        if selection == "other":
            place = self.memories[self.attended].position
            return (0.0 if place is None else math.dist(memory.position, place)), number
        offset = memory.position - self._field.middle
        if selection == "nearest":
            return math.hypot(*offset.tolist()), number
        azimuth = math.atan2(offset[1], offset[0])
        return (-azimuth if selection == "leftmost" else azimuth), number

    def look(self, time: float, exposed: float, seen: Sightings, others: Sightings = ()) -> None:
        """Update sightings and memories from the newest images.

        Args:
            time: Current time, s.
            exposed: Time of exposure of the images, s.
            seen: Sightings of the channel's regions by camera, the largest first.
            others: Sightings of the other channels' regions by camera.
        """
        self._exposed, self._others = exposed, others
        for each in self.sightings:
            each.clear()
        known = self.known
        if not known:
            self.attended = 0
        if self._is_one_thing(seen, known):
            for each, sightings in zip(self.sightings, seen, strict=True):
                if sightings:
                    each[self.attended] = sightings[0]
            if self._stereo:
                self._remember(time, self.attended)
        elif self._stereo:
            self._tell_apart(time, seen, known)
        else:
            for each, sightings in zip(self.sightings, seen, strict=True):
                each[self.attended] = sightings[0]
        self._attend()

    def _is_one_thing(self, seen: Sightings, known: Sequence[int]) -> bool:
        """Return whether all sightings may show the one known object, or the first one."""
        if len(known) > 1 or any([len(sightings) > 1 for sightings in seen]):
            return False
        if not known:
            return True
        self.attended = known[0]
        memory = self.memories[known[0]]
        assert memory.position is not None
        reach, position = memory.radius + BESIDE, memory.position
        if all([each.distance(position) <= reach for one in seen for each in one]):
            return True
        # An unoccluded object away from its remembered position has moved.
        if not self._is_hidden(known[0]):
            return self._field.shows(position, memory.radius)
        far = reach + self._settings.hand_radius
        return all([each.distance(position) <= far for one in seen for each in one])

    def _remember(self, time: float, number: int, *, believed: bool = True) -> None:
        """Update the memory of one object from the newest images."""
        memory = self.memories[number]
        sighting = self._located(number) if believed else None
        if sighting is not None and (memory.position is not None or self._is_whole(number)):
            position, _, sizes = sighting
            aside = self._aside(number)
            if memory.has_shrunk(sizes, aside) and not self._may_be_hidden(number, position):
                memory.forget_size(sizes, aside)
            if memory.see(time, position + memory.moved_since(self._exposed), sizes):
                return
        if memory.position is not None:
            memory.miss(time, explained=self._explains(time, number))

    def _may_be_hidden(self, number: int, position: Floats) -> bool:
        """Return whether a hand or another object may occlude a part of an object.

        Args:
            number: Number of the object.
            position: Position at which it is seen now, m, shape (3,).
        """
        if self._field.is_hidden_by_hand(position):
            return True
        return self.memories[number].position is not None and any(self._covered(number))

    def _aside(self, number: int) -> list[float]:
        """Return the distances of an object's lines of sight from its remembered position, m."""
        place = self.memories[number].position
        return [0.0 if place is None else each[number].distance(place) for each in self.sightings]

    def _is_whole(self, number: int) -> bool:
        """Return whether the regions of a newly seen object are compact, and so one object."""
        return all(is_compact(each[number].region) for each in self.sightings)

    def _located(self, number: int) -> Meeting | None:
        """Return where both cameras see an object whole, or ``None``."""
        left, right = [each.get(number) for each in self.sightings]
        if left is None or right is None or left.region.clipped or right.region.clipped:
            return None
        meeting = meet(left, right, self._settings.farthest)
        if meeting is None or meeting.gap > self._settings.ray_gap:
            return None
        return meeting

    def _explains(self, time: float, number: int) -> bool:
        """Return whether an unseen object may still be at its remembered position."""
        memory = self.memories[number]
        position, radius = memory.position, memory.radius
        assert position is not None
        if self._is_hidden(number):
            return True
        if not self._field.shows(position, radius):
            # The position of an object that moved out of view is unknown.
            return not memory.is_lost(time)
        reach, seen = radius + BESIDE, [each[number] for each in self.sightings if number in each]
        if any(sighting.distance(position) <= reach for sighting in seen):
            return True
        return not memory.is_lost(time) and self._is_within_another(number)

    def _is_within_another(self, number: int) -> bool:
        """Return whether an object may be a part of another object's region, which has grown."""
        for claims in self.sightings:
            for other, sighting in claims.items():
                memory = self.memories[other]
                if other == number or memory.position is None:
                    continue
                grown = sighting.radius(memory.position) >= _GROWN * memory.radius
                if grown and self._touches(sighting, number):
                    return True
        return False

    def _is_hidden(self, number: int) -> bool:
        """Return whether an object is occluded in every image that would otherwise show it."""
        memory = self.memories[number]
        assert memory.position is not None
        if self._field.is_hidden_by_hand(memory.position):
            return True
        hidden = self._hidden_by_others(number)
        if not any(hidden):
            return False
        views = self._field.views(memory.position, memory.radius)
        return all(hides or not view for hides, view in zip(hidden, views, strict=True))

    def _hidden_by_others(self, number: int) -> list[bool]:
        """Return for each camera whether other objects occlude an object."""
        memory = self.memories[number]
        assert memory.position is not None
        others = [
            (other.position, other.radius)
            for other in self.memories
            if other is not memory and other.position is not None
        ]
        hidden = self._field.hidden_by((memory.position, memory.radius), others)
        return [
            hides or covers for hides, covers in zip(hidden, self._covered(number), strict=True)
        ]

    def _covered(self, number: int) -> list[bool]:
        """Return for each camera whether another channel's region covers an object's middle.

        A much larger region, such as that of a table, is a background and covers nothing.
        """
        memory = self.memories[number]
        assert memory.position is not None
        position, most = memory.position, _BACKGROUND * memory.radius
        if not self._others:
            return [False] * self._cameras
        return [
            any(
                sighting.distance(position) < sighting.radius(position) < most
                for sighting in sightings
            )
            for sightings in self._others
        ]

    def _tell_apart(self, time: float, seen: Sightings, known: Sequence[int]) -> None:
        """Update from images with several regions, or with an object other than the known one."""
        for each, sightings in zip(self.sightings, seen, strict=True):
            self._claim(each, sightings, known)
        for number in known:
            self._retract(number)
        grown = {k for k in known if self._has_grown_together(k, known)}
        for number in known:
            self._remember(time, number, believed=number not in grown)
        left, right = (
            [sighting for sighting in sightings if sighting not in each.values()]
            for each, sightings in zip(self.sightings, seen, strict=True)
        )
        certain, _ = pair(left, right, self._settings)
        fresh = [each for each in certain if self._may_be_another(each, left, right)]
        before, self._candidates = self._candidates, [each.meeting.position for each in fresh]
        for candidate in sorted(fresh, key=lambda candidate: -sum(candidate.meeting.sizes)):
            if not known or _is_near(candidate.meeting.position, before):
                sightings = left[candidate.left], right[candidate.right]
                self._discover(time, sightings, candidate.meeting)
        self._offer(left, right, certain)

    def _claim(
        self, claims: dict[int, Sighting], sightings: Sequence[Sighting], known: Sequence[int]
    ) -> None:
        """Assign to each remembered object a sighting that leads to it, the nearest pairs first."""
        options = []
        for number in known:
            memory = self.memories[number]
            assert memory.position is not None
            for place, sighting in enumerate(sightings):
                distance = sighting.distance(memory.position)
                if distance <= memory.radius + BESIDE:
                    options.append((distance, number, place))
        taken = set()
        for _, number, place in sorted(options):
            if number not in claims and place not in taken:
                claims[number] = sightings[place]
                taken.add(place)

    def _retract(self, number: int) -> None:
        """Remove a sighting by one camera if the other should see the object, too, and does not."""
        memory = self.memories[number]
        assert memory.position is not None
        claims = [number in each for each in self.sightings]
        if claims[0] == claims[1] or self._field.is_hidden_by_hand(memory.position):
            return
        other = claims.index(False)
        views = self._field.views(memory.position, memory.radius)
        if views[other] and not self._hidden_by_others(number)[other]:
            del self.sightings[1 - other][number]

    def _has_grown_together(self, number: int, known: Sequence[int]) -> bool:
        """Return whether an object's region may also show another object or a part of it.

        The other object either has no region of its own, or a hand leaves only parts of it visible.
        """
        return any(
            self._touches(claims[number], other) and not self._is_seen_whole(claims, other)
            for row, claims in enumerate(self.sightings)
            if number in claims
            for other in known
            if other != number and not self._is_just_before(row, number, other)
        )

    def _is_seen_whole(self, claims: dict[int, Sighting], number: int) -> bool:
        """Return whether an object has a region of its own of nearly its full size."""
        memory = self.memories[number]
        assert memory.position is not None
        seen = claims.get(number)
        return seen is not None and seen.radius(memory.position) >= _NEARLY * memory.radius

    def _touches(self, sighting: Sighting, other: int) -> bool:
        """Return whether a region reaches the expected image of a remembered object."""
        memory = self.memories[other]
        assert memory.position is not None
        gap = sighting.distance(memory.position) - memory.radius
        return gap < sighting.radius(memory.position)

    def _is_just_before(self, row: int, number: int, other: int) -> bool:
        """Return whether a camera sees an object, no larger than it is, in front of another one.

        The result is false for an object that a hand may occlude, because the size of its own part
        of a region is unknown.
        """
        memory, behind = self.memories[number], self.memories[other]
        assert memory.position is not None
        assert behind.position is not None
        if self._field.is_hidden_by_hand(memory.position):
            return False
        sighting = self.sightings[row][number]
        if sighting.radius(memory.position) >= _GROWN * memory.radius:
            return False
        ball = behind.position, behind.radius
        return self._field.hidden_by(ball, [(memory.position, memory.radius)])[row]

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
        return all(
            memory.position is None
            or math.dist(memory.position, candidate.meeting.position) > max(memory.radius, radius)
            for memory in self.memories
        )

    def _may_be_fragments(self, sightings: Sequence[Sighting]) -> bool:
        """Return whether sightings may be fragments of a remembered object behind a hand.

        Two cameras see different parts of it between the fingers. Their lines of sight meet at a
        wrong position.
        """
        return any(
            memory.position is not None
            and any(each.distance(memory.position) <= memory.radius for each in sightings)
            and self._field.is_hidden_by_hand(memory.position)
            for memory in self.memories
        )

    def _discover(
        self, time: float, sightings: tuple[Sighting, Sighting], meeting: Meeting
    ) -> None:
        """Remember a new object, or one that has moved, if a number is available."""
        free = (k for k, each in enumerate(self.memories) if each.position is None)
        number = next(self._moved(meeting.position), None)
        number = next(free, None) if number is None else number
        if number is None:
            return
        self.memories[number].reset()
        self.memories[number].see(time, meeting.position, meeting.sizes)
        for each, sighting in zip(self.sightings, sightings, strict=True):
            each[number] = sighting

    def _moved(self, position: Floats) -> Iterator[int]:
        """Yield objects that are unseen at their place and may have moved to a position."""
        for number in self.known:
            memory = self.memories[number]
            assert memory.position is not None
            if any(number in each for each in self.sightings):
                continue
            if not self._field.shows(memory.position, memory.radius):
                continue
            near = math.dist(memory.position, position) <= self._settings.hand_radius
            if near or not self._is_hidden(number):
                yield number

    def _attend(self) -> None:
        """Keep attention on a remembered object, or move it to the nearest one."""
        if not self.memories:
            return
        if self.memories[self.attended].position is None:
            known = self.known
            if not known:
                return
            self.attended = min(known, key=self._priority)
        self._place = self.memories[self.attended].position

    def _priority(self, number: int) -> tuple[float, float, int]:
        """Return a sorting key: distance from the last place of attention, then largest area."""
        position, place = self.memories[number].position, self._place
        assert position is not None
        distance = 0.0 if place is None else math.dist(position, place)
        area = sum(each[number].region.area for each in self.sightings if number in each)
        return distance, -area, number

    def _offer(
        self, left: Sequence[Sighting], right: Sequence[Sighting], certain: Sequence[Pair]
    ) -> None:
        """Give the largest region that shows no remembered object the lowest free number.

        This defines headings to an object without a position, which one camera does not see or sees
        partly. Its counterpart in the other image gets the same number.
        """
        free = next((k for k, each in enumerate(self.memories) if each.position is None), None)
        options = [
            (-sighting.region.area, row, number)
            for row, sightings in enumerate((left, right))
            for number, sighting in enumerate(sightings)
            if not self._is_part_of_known(sighting)
        ]
        if free is None or not options:
            return
        _, row, number = min(options)
        self.sightings[row][free] = (left, right)[row][number]
        for each in certain:
            numbers = each.left, each.right
            if numbers[row] == number:
                other = 1 - row
                self.sightings[other][free] = (left, right)[other][numbers[other]]

    def _is_part_of_known(self, sighting: Sighting) -> bool:
        """Return whether a line of sight leads to a remembered object."""
        return any(
            memory.position is not None and sighting.distance(memory.position) <= memory.radius
            for memory in self.memories
        )


def is_compact(region: Region) -> bool:
    """Return whether a region is a single one, and not two merged round ones."""
    columns, mixed, rows = region.moments
    middle, half = (columns + rows) / 2, math.hypot((columns - rows) / 2, mixed)
    longer, shorter = middle + half, max(middle - half, 0.0)
    ellipse = 4 * math.pi * math.sqrt(longer * shorter)
    merged = _LONG**2 * shorter <= longer < _SLENDER**2 * shorter
    return region.area >= _FILLED * ellipse or not merged


def _is_near(position: Floats, places: Sequence[Floats]) -> bool:
    return any(math.dist(position, place) <= _STEADY for place in places)

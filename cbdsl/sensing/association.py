"""Association: which regions in the images of two cameras show the same thing (Eq 3.14).

Lines of sight to one thing nearly meet, and it looks as large from both cameras as its distances
let it. Where several things meet both conditions with several others, they stand side by side on
one plane through both cameras, which see them in the same order; where their numbers differ, too,
nobody can tell them apart, and they are left alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Regions
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.sighting import Sighting
from cbdsl.sensing.stereo import cross_rays

Floats = NDArray[np.float64]

# Least ratio of the sizes of a thing as two cameras see it: they see other sides of a box.
_ALIKE = 0.65
# Lines of sight to the middle of what is cut off by an image's border miss each other by more.
_CLIPPED_GAP = 0.1


class Meeting(NamedTuple):
    """Where two lines of sight meet.

    Attributes:
        position: m, world frame, shape (3,).
        gap: by how much they miss each other, m.
        sizes: of what the regions show if it is there, m^2: area times squared distance.
    """

    position: Floats
    gap: float
    sizes: tuple[float, float]


class Pair(NamedTuple):
    """Two sightings of one thing.

    Attributes:
        left, right: their numbers among the cameras' sightings.
        meeting: of their lines of sight.
        whole: whether both images show all of it.
    """

    left: int
    right: int
    meeting: Meeting
    whole: bool


def meet(left: Sighting, right: Sighting, farthest: float) -> Meeting | None:
    """Where two lines of sight meet; ``None`` behind a camera or beyond the farthest, m."""
    position, sizes = np.empty(3), np.empty(2)
    gap = _meet(
        *left.ray, *right.ray, (left.focal_length, right.focal_length), farthest, position, sizes
    )
    if not gap < math.inf:
        return None
    own, other = sizes.tolist()
    return Meeting(
        position,
        gap,
        (own * left.region.area * left.scale, other * right.region.area * right.scale),
    )


@compiled_once
def _meet(
    left: Floats,
    left_direction: Floats,
    left_length: float,
    right: Floats,
    right_direction: Floats,
    right_length: float,
    focal_lengths: tuple[float, float],
    farthest: float,
    position: Floats,
    sizes: Floats,
) -> float:
    """Fill in a meeting's position and the size of a pixel there, m^2; returns the gap, or NaN."""
    gap = cross_rays(
        left, left_direction, left_length, right, right_direction, right_length, position
    )
    for eye in range(2):
        origin, square = left if eye == 0 else right, 0.0
        for i in range(3):
            square += (position[i] - origin[i]) ** 2
        if square > farthest * farthest:
            return math.nan
        sizes[eye] = square / focal_lengths[eye] ** 2
    return gap


def pair(
    left: Sequence[Sighting], right: Sequence[Sighting], settings: Regions
) -> tuple[list[Pair], list[Pair]]:
    """Pairs that show one thing each, and pairs of which nobody can tell whether they do.

    Args:
        left, right: sightings of one channel by the two cameras.
        settings: largest gap between lines of sight, and largest distance.
    """
    possible = [
        candidate
        for i, one in enumerate(left)
        for j, other in enumerate(right)
        if (candidate := _candidate(i, one, j, other, settings)) is not None
    ]
    certain: list[Pair] = []
    ambiguous: list[Pair] = []
    for group in _groups(possible):
        resolved = _in_order(group, left, right)
        (certain if resolved else ambiguous).extend(resolved or group)
    return certain, ambiguous


def _candidate(i: int, one: Sighting, j: int, other: Sighting, settings: Regions) -> Pair | None:
    meeting = meet(one, other, settings.farthest)
    if meeting is None:
        return None
    whole = not (one.region.clipped or other.region.clipped)
    if meeting.gap > (settings.ray_gap if whole else _CLIPPED_GAP):
        return None
    if whole and not look_alike(meeting.sizes):
        return None
    return Pair(i, j, meeting, whole)


def look_alike(sizes: Sequence[float]) -> bool:
    """Whether two cameras may see the whole of one thing, which looks that large to them, m^2."""
    return min(sizes) >= _ALIKE * max(sizes)


def _groups(possible: Sequence[Pair]) -> Iterator[list[Pair]]:
    """Pairs that share sightings, directly or through others."""
    others = list(possible)
    while others:
        group: list[Pair] = []
        joined = [others.pop(0)]
        while joined:
            group += joined
            lefts, rights = {each.left for each in group}, {each.right for each in group}
            joined = [each for each in others if each.left in lefts or each.right in rights]
            others = [each for each in others if each not in joined]
        yield group


def _in_order(
    group: Sequence[Pair], left: Sequence[Sighting], right: Sequence[Sighting]
) -> list[Pair]:
    """Pairs of a group in the order from one camera to the other; none where that has gaps."""
    lefts, rights = {each.left for each in group}, {each.right for each in group}
    if len(lefts) != len(rights):
        return []
    one, other = left[group[0].left].ray, right[group[0].right].ray
    baseline = other.origin - one.origin

    def across(sighting: Sighting) -> float:
        return float(sighting.ray.direction.dot(baseline)) / sighting.ray.length

    by_numbers = {(each.left, each.right): each for each in group}
    ordered = zip(
        sorted(lefts, key=lambda number: across(left[number])),
        sorted(rights, key=lambda number: across(right[number])),
        strict=True,
    )
    resolved = [by_numbers.get(numbers) for numbers in ordered]
    return [each for each in resolved if each is not None] if all(resolved) else []

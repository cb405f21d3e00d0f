"""Stereo correspondences between the regions in the images of two cameras (Eq 3.14).

Lines of sight to one object nearly meet, and its apparent sizes fit its distances from both
cameras. If several regions of one image match several of the other, the objects are side by side on
one plane through both cameras. Both images then have them in the same order. If the numbers of
regions differ, the correspondences are ambiguous and are not resolved.
"""

# Model: a region is the image of a ball. Its line of sight is x = o + t d, with the optical centre
# o and the direction d of the centroid. Two lines match if they nearly meet in front of both
# cameras:
#     gap = |(o_2 - o_1) . (d_1 x d_2)| / |d_1 x d_2| <= ray_gap
# The meeting point is the middle of the shortest segment between the lines. Each camera then yields
# a size, area (distance / focal length)^2, and the ratio of the two sizes must be at least _ALIKE.
# A match of several regions with several others, all on one plane through both optical centres, is
# resolved by the ordering constraint: along the baseline, both images show the same order.
# Assumptions: no object stands in front of another one within such a plane, because the order would
# then be reversed. Groups with missing regions are ambiguous, since the missing one is unknown.
# Clipped regions have shifted centroids. They get a wider gap and no comparison of sizes.
# Source: Eq 3.14 for triangulation; Baker and Binford (1981) for the ordering constraint.

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.documents.robot import Regions
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.association.stereo import cross_rays

# Least ratio of the sizes of an object in two cameras, which see different sides of a box.
_ALIKE = 0.65
# Largest gap, m, for clipped regions: lines of sight to their middles miss each other by more.
_CLIPPED_GAP = 0.1


class Meeting(NamedTuple):
    """Meeting point of two lines of sight.

    Attributes:
        position: Meeting point, m, world frame, shape (3,).
        gap: Distance by which the lines miss each other, m.
        sizes: Area times squared distance of the object in each camera if it is there, m^2.
    """

    position: Floats
    gap: float
    sizes: tuple[float, float]


class Pair(NamedTuple):
    """Two sightings of one object.

    Attributes:
        left, right: Numbers of the sightings among those of each camera.
        meeting: Meeting point of the lines of sight.
        whole: True if both images show the whole object.
    """

    left: int
    right: int
    meeting: Meeting
    whole: bool


def meet(left: Sighting, right: Sighting, farthest: float) -> Meeting | None:
    """Return where two lines of sight meet, ``None`` behind a camera or beyond ``farthest``, m."""
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
    """Write a meeting's position and the size of a pixel there, m^2; return the gap, m, or NaN."""
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
    """Return the unambiguous and the ambiguous stereo correspondences.

    Args:
        left: Sightings of a channel by the left camera.
        right: Sightings of the channel by the right camera.
        settings: Largest gap between lines of sight, and largest distance.
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
    """Return whether two sizes, m^2, may be those of one whole object in two cameras."""
    return min(sizes) >= _ALIKE * max(sizes)


def _groups(possible: Sequence[Pair]) -> Iterator[list[Pair]]:
    """Yield groups of pairs that share sightings, directly or through other pairs."""
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
    """Return pairs of a group in their order along the baseline; none if the order has gaps."""
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

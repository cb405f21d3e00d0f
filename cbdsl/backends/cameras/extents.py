"""Extents of boxes that fill an ideal camera's image."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import cv2
import numpy as np

from cbdsl.backends.staging.solids import HALVES, POSITION, ROTATION
from cbdsl.numeric.arrays import Booleans, Floats
from cbdsl.sensing.channels import GRID, Extent

_NEAREST = 0.02
"""Least distance ahead of a camera at which an object is visible, m."""

_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
# The index of a corner has one bit per axis, so an edge joins two corners that differ in one bit.
_EDGES = np.array(
    [(a, b) for a, b in itertools.combinations(range(8), 2) if (a ^ b).bit_count() == 1]
)


def box_extent(
    box: Floats, camera: Floats, lens: Floats, unhidden: Callable[[Floats], Booleans]
) -> Extent:
    """Return the visible part of a box, as an image shows it.

    Args:
        box: Row of the box, as in ``solids``, shape (16,).
        camera: Placement of the camera, with the axes ahead, left and up, shape (12,).
        lens: Focal length, width and height of the image, px, shape (3,).
        unhidden: Function from pixels, shape (k, 2), to whether the box is visible at each.
    """
    # A clipped region of a large box has a centroid that moves with the image's border. Its outline
    # and its inner points still show the position of the box.
    hull = _hull(box, camera, lens)
    if hull is None:
        return Extent((), ())
    pieces = [
        piece
        for start, end in zip(hull, np.roll(hull, -1, axis=0), strict=True)
        for piece in _pieces(start, end, lens[1:])
    ]
    if pieces:
        # A pixel towards the middle, on the box itself.
        middles = np.array(pieces).reshape(-1, 2, 2).mean(axis=1)
        inward = hull.mean(axis=0) - middles
        seen = unhidden(middles + inward / np.linalg.norm(inward, axis=1, keepdims=True))
        pieces = [piece for piece, is_seen in zip(pieces, seen, strict=True) if is_seen]
    return Extent(tuple(pieces), _cover(hull, lens[1:], unhidden))


def _hull(box: Floats, camera: Floats, lens: Floats) -> Floats | None:
    """Return the corners of the silhouette, px, shape (k, 2)."""
    turned, axes = box[ROTATION].reshape(3, 3), camera[:9].reshape(3, 3)
    corners = (box[POSITION] + (_CORNERS * box[HALVES]).dot(turned.T) - camera[9:]).dot(axes)
    starts, ends = corners[_EDGES[:, 0]], corners[_EDGES[:, 1]]
    # The projection is valid only ahead of the camera. Edges that cross the nearest plane are cut
    # there, and the corners behind the plane are left out.
    cut = (starts[:, 0] - _NEAREST) * (ends[:, 0] - _NEAREST) < 0
    share = (_NEAREST - starts[cut, 0]) / (ends[cut, 0] - starts[cut, 0])
    met = starts[cut] + share[:, None] * (ends[cut] - starts[cut])
    ahead = np.concatenate([corners[corners[:, 0] >= _NEAREST], met])
    if len(ahead) < 3:
        return None
    focal, width, height = lens
    columns = width / 2 - focal * ahead[:, 1] / ahead[:, 0]
    rows = height / 2 - focal * ahead[:, 2] / ahead[:, 0]
    # Perspective maps convex bodies to convex images, so the hull of the projected corners is the
    # silhouette.
    hull = cv2.convexHull(np.stack([columns, rows], axis=-1).astype(np.float32))
    return np.asarray(hull[:, 0], dtype=float)


def _pieces(start: Floats, end: Floats, size: Floats) -> list[tuple[float, float, float, float]]:
    """Return the part of a segment within the image, in pieces as long as the grid spacing."""
    # The segment is clipped by each pair of borders in turn (Liang and Barsky): its parameters
    # inside of the image are the intersection of the intervals. A segment outside has low > high,
    # and a negative length.
    along, low, high = end - start, 0.0, 1.0
    for axis in range(2):
        if along[axis] == 0.0:
            if not 0.0 < start[axis] < size[axis]:
                return []
            continue
        one, other = sorted(((0.0 - start[axis]) / along[axis],
                             (size[axis] - start[axis]) / along[axis]))  # fmt: skip
        low, high = max(low, one), min(high, other)
    length = float((high - low) * np.hypot(*along))
    if length < GRID / 2:
        return []
    ends = start + np.linspace(low, high, max(2, 1 + round(length / GRID)))[:, None] * along
    return [(*one, *other) for one, other in itertools.pairwise(map(tuple, ends.tolist()))]


def _cover(
    hull: Floats, size: Floats, unhidden: Callable[[Floats], Booleans]
) -> tuple[tuple[float, float], ...]:
    width, height = size
    contour = hull.astype(np.float32)
    inside = [
        (column, row)
        for row in np.arange(GRID // 2 + 0.5, height, GRID).tolist()
        for column in np.arange(GRID // 2 + 0.5, width, GRID).tolist()
        if cv2.pointPolygonTest(contour, (column, row), True) >= GRID / 2
    ]
    if not inside:
        return ()
    seen = unhidden(np.array(inside))
    return tuple(point for point, is_seen in zip(inside, seen, strict=True) if is_seen)

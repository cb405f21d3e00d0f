"""Regions of the hue, saturation, intensity and motion channels in images (Eq 3.10)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import reduce
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Channels
from cbdsl.numeric.arrays import Image
from cbdsl.robot.channel_spans import Span, channel_spans

#: Largest number of regions of one channel in an image; smaller ones are omitted.
MOST_REGIONS = 6

# A grey value has to change by this much between two images to count as motion: well above the
# noise of a camera, well below the contrast of an object against a table.
_MOTION_STEP = 24


#: Least share of an image that a clipped region covers to have an extent.
FILLING = 1 / 16
#: Distance between the pixels of an extent, px.
GRID = 16
# Largest area of a fragment of a region, as a share of the region's.
_FRAGMENT = 0.01
# Largest distance of an outline's pixels from its segments, and the shortest segment, px.
_STRAIGHT, _LEAST_SEGMENT = 1.0, 6.0


class Moments(NamedTuple):
    """Second central moments of a region, with each of its pixels a unit square, px^2.

    Attributes:
        columns: Variance of the columns.
        mixed: Covariance of columns and rows.
        rows: Variance of the rows.
    """

    columns: float
    mixed: float
    rows: float


class Extent(NamedTuple):
    """Visible part of a surface that is larger than an image, px.

    Attributes:
        outline: Straight segments of the outline that are not at the image's border: column and row
            of one end, then of the other.
        cover: Pixels on a grid, as column and row, well inside the surface.
    """

    outline: tuple[tuple[float, float, float, float], ...]
    cover: tuple[tuple[float, float], ...]


class Region(NamedTuple):
    """Connected region of a channel in one image.

    Attributes:
        area: Number of pixels.
        column: Centroid from the left edge, px; the centre of the first pixel is at 0.5.
        row: Centroid from the top edge, px.
        clipped: True if the region touches the image border, so that a part may be out of view.
        moments: Second central moments.
        extent: Visible part of a clipped region that fills at least ``FILLING`` of the image.
    """

    area: int
    column: float
    row: float
    clipped: bool
    moments: Moments
    extent: Extent | None = None


Regions = tuple[Region, ...]
"""Regions of a channel in one image, the largest first."""


class ChannelFilter:
    """Detector of the regions of each requested channel in successive images of one camera.

    Hue bins are centred: ``hue_1`` on red, so that the noise of a pure colour stays in one bin.
    """

    def __init__(self, channels: Channels, wanted: Iterable[str], least_area: int) -> None:
        self._spans = channel_spans(channels)
        self._wanted = tuple(wanted)
        self._least_area = least_area
        self._before: Image | None = None

    def reset(self) -> None:
        """Forget the previous image."""
        self._before = None

    def regions(self, image: Image) -> Mapping[str, Regions]:
        """Return the regions of each requested channel that has any, the largest first.

        Args:
            image: RGB image, shape (height, width, 3), top row first.
        """
        hsv = cv2.cvtColor(image, cv2.COLOR_RGB2HSV_FULL)
        regions: dict[str, Regions] = {}
        for name in self._wanted:
            spans = self._spans.get(name)
            mask = self._motion(image) if spans is None else _in_any(hsv, spans)
            several = () if mask is None else connected_regions(mask, self._least_area)
            if several:
                regions[name] = several
        self._before = image
        return regions

    def _motion(self, image: Image) -> Image | None:
        if self._before is None:
            return None
        change = cv2.absdiff(
            cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), cv2.cvtColor(self._before, cv2.COLOR_RGB2GRAY)
        )
        mask: Image = cv2.inRange(change, _MOTION_STEP, 255)
        return mask


def _in_any(hsv: Image, spans: Iterable[Span]) -> Image:
    """Return the mask of the pixels within any of some spans."""
    mask: Image = reduce(cv2.bitwise_or, (cv2.inRange(hsv, *map(np.array, each)) for each in spans))
    return mask


def connected_regions(mask: Image, least_area: int) -> Regions:
    """Return the connected regions of a mask of at least ``least_area`` px, the largest first.

    At most ``MOST_REGIONS`` are returned. Of equally large regions, the upper comes first.
    """
    # Most masks are empty, and counting pixels is much cheaper than labelling.
    if cv2.countNonZero(mask) < least_area:
        return ()
    # Labelling takes most of the time, so only the bounding box is labelled.
    left, top, width, height = cv2.boundingRect(mask)
    window = mask[top : top + height, left : left + width]
    count, labels, statistics, centroids = cv2.connectedComponentsWithStats(window, connectivity=8)
    if count > 2:
        _add_fragments(labels, statistics, centroids)
    areas = statistics[1:, cv2.CC_STAT_AREA]
    # A mask has either one region or hundreds of specks.
    order = np.argsort(-areas, kind="stable")[:MOST_REGIONS] if count > 2 else (0,)
    place = _Window(left, top, mask.shape[1], mask.shape[0])
    return tuple(
        _region(labels, 1 + label, statistics[1 + label], centroids[1 + label], place)
        for label in order
        if areas[label] >= least_area
    )


def _add_fragments(labels: Any, statistics: Any, centroids: Any) -> None:
    """Merge fragments that the largest region encloses into it.

    Between fine bars printed on an object, an image has specks of the object's colour.
    """
    areas = statistics[:, cv2.CC_STAT_AREA]
    largest = 1 + int(np.argmax(areas[1:]))
    x, y, width, height, area = statistics[largest].tolist()
    lefts, tops, widths, heights, _ = statistics.T
    inner = (lefts > x) & (tops > y) & (lefts + widths < x + width) & (tops + heights < y + height)
    fragments = np.flatnonzero(inner & (areas <= _FRAGMENT * area))
    if not fragments.size:
        return
    # The bounding box is a fast first test. The filled outline decides: a speck in the notch of an
    # L, for example, is inside the box and outside of the region.
    own = (labels[y : y + height, x : x + width] == largest).astype(np.uint8)
    contours, _ = cv2.findContours(own, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = cv2.drawContours(np.zeros_like(own), contours, -1, 1, cv2.FILLED)
    columns, rows = np.rint(centroids[fragments] - (x, y)).astype(int).T
    enclosed = fragments[filled[rows, columns] == 1]
    parts = np.array([largest, *enclosed])
    centroids[largest] = areas[parts] @ centroids[parts] / areas[parts].sum()
    areas[largest] = areas[parts].sum()
    areas[enclosed] = 0
    labels[np.isin(labels, enclosed)] = largest


class _Window(NamedTuple):
    """Part of an image: its first column and row, and the size of the whole image, px."""

    left: int
    top: int
    columns: int
    rows: int


def _region(labels: Any, label: int, statistics: Any, centroid: Any, window: _Window) -> Region:
    x, y, width, height, area = statistics.tolist()
    left, top = x + window.left, y + window.top
    columns, rows = window.columns, window.rows
    clipped = left == 0 or top == 0 or left + width == columns or top + height == rows
    column, row = centroid.tolist()
    own = labels[y : y + height, x : x + width] == label
    extent = None
    if clipped and area >= FILLING * rows * columns:
        whole = np.zeros((rows, columns), bool)
        whole[top : top + height, left : left + width] = own
        extent = _extent(whole)
    middle = column + window.left + 0.5, row + window.top + 0.5
    return Region(area, *middle, clipped, _moments(own), extent)


def _extent(mask: NDArray[np.bool_]) -> Extent:
    image = mask.view(np.uint8)
    contours, _ = cv2.findContours(image, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    corners = cv2.approxPolyDP(contours[0], _STRAIGHT, closed=True)[:, 0]
    ends = np.hstack([corners, np.roll(corners, -1, axis=0)])
    rows, columns = mask.shape
    last = np.array([columns - 1, rows - 1])
    # A segment with both ends on one border is the edge of the view and not of the surface.
    borders = [(ends.reshape(-1, 2, 2) == edge).all(axis=1) for edge in (np.zeros(2), last)]
    inner = ~np.any(borders, axis=(0, 2))
    long = np.hypot(*(ends[:, 2:] - ends[:, :2]).T) >= _LEAST_SEGMENT
    outline = ends[inner & long] + 0.5
    # Erosion leaves the pixels at least half a grid step inside the region along both axes.
    inside = cv2.erode(image, np.ones((GRID + 1, GRID + 1), np.uint8))[GRID // 2 :: GRID]
    row, column = np.nonzero(inside[:, GRID // 2 :: GRID])
    cover = np.stack([column, row], axis=-1) * GRID + (GRID // 2 + 0.5)
    return Extent(tuple(map(tuple, outline.tolist())), tuple(map(tuple, cover.tolist())))


def _moments(mask: NDArray[np.bool_]) -> Moments:
    sums = cv2.moments(mask.view(np.uint8), binaryImage=True)
    area, square = sums["m00"], 1 / 12  # variance of a pixel's own square
    return Moments(sums["mu20"] / area + square, sums["mu11"] / area, sums["mu02"] / area + square)

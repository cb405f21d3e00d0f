"""From pixels to regions: the hue, saturation, intensity and motion channels (Eq 3.10)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Channels

Image = NDArray[np.uint8]

# A grey value has to change by this much between two images to count as motion: well above the
# noise of a camera, well below the contrast of a thing against a table.
_MOTION_STEP = 24


class Region(NamedTuple):
    """The largest connected region of a channel in one image.

    Attributes:
        area: px.
        column: centroid from the left edge, px; the centre of the first pixel is at 0.5.
        row: centroid from the top edge, px.
        clipped: whether it touches the image border, so that part of it may be out of sight.
    """

    area: int
    column: float
    row: float
    clipped: bool


class ChannelFilter:
    """Finds the region of each wanted channel in the successive images of one camera.

    Hue bins are centred: ``hue_1`` on red, so that the noise of a pure colour stays in one bin.
    """

    def __init__(self, channels: Channels, wanted: Iterable[str], least_area: int) -> None:
        self._channels = channels
        self._wanted = tuple(wanted)
        self._least_area = least_area
        self._before: Image | None = None

    def reset(self) -> None:
        """Forget the image before."""
        self._before = None

    def regions(self, image: Image) -> Mapping[str, Region]:
        """The region of each wanted channel that has one.

        Args:
            image: RGB, shape (height, width, 3), top row first.
        """
        hue, saturation, intensity = cv2.split(cv2.cvtColor(image, cv2.COLOR_RGB2HSV_FULL))
        regions: dict[str, Region] = {}
        for name in self._wanted:
            mask = self._mask(name, image, hue, saturation, intensity)
            region = None if mask is None else largest_region(mask, self._least_area)
            if region is not None:
                regions[name] = region
        self._before = image
        return regions

    def _mask(
        self, name: str, image: Image, hue: Image, saturation: Image, intensity: Image
    ) -> Image | None:
        if name == "motion":
            return self._motion(image)
        prefix, number = name.split("_")
        index = int(number) - 1
        if prefix == "int":
            return bin_mask(intensity, index, self._channels.intensity)
        lit = _at_least(intensity, 255 * self._channels.least_intensity)
        if prefix == "sat":
            return _both(lit, bin_mask(saturation, index, self._channels.saturation))
        colored = _both(lit, _at_least(saturation, 255 * self._channels.least_saturation))
        count = self._channels.hue
        # Unsigned bytes wrap around as hues do.
        centred: Image = hue + np.uint8(round(128 / count))
        return _both(colored, bin_mask(centred, index, count))

    def _motion(self, image: Image) -> Image | None:
        if self._before is None:
            return None
        change = cv2.absdiff(
            cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), cv2.cvtColor(self._before, cv2.COLOR_RGB2GRAY)
        )
        return _at_least(change, _MOTION_STEP)


def _both(one: Image, other: Image) -> Image:
    mask: Image = cv2.bitwise_and(one, other)
    return mask


def _at_least(plane: Image, least: float) -> Image:
    mask: Image = cv2.inRange(plane, int(np.ceil(least)), 255)
    return mask


def bin_mask(plane: Image, index: int, count: int) -> Image:
    """Mask of the values in bin ``index`` of ``count`` equal bins of 0..255."""
    lower = np.ceil(256 * index / count)
    upper = np.ceil(256 * (index + 1) / count) - 1
    mask: Image = cv2.inRange(plane, int(lower), int(upper))
    return mask


def largest_region(mask: Image, least_area: int) -> Region | None:
    """The largest connected region of a mask, or ``None`` where all are below ``least_area``."""
    # Most masks are empty: finding that out is much cheaper than labelling.
    if cv2.countNonZero(mask) < least_area:
        return None
    _, _, statistics, centroids = cv2.connectedComponentsWithStats(mask, connectivity=8)
    label = 1 + int(np.argmax(statistics[1:, cv2.CC_STAT_AREA]))
    left, top, width, height, area = (int(value) for value in statistics[label])
    if area < least_area:
        return None
    rows, columns = mask.shape
    clipped = left == 0 or top == 0 or left + width == columns or top + height == rows
    return Region(area, float(centroids[label, 0]) + 0.5, float(centroids[label, 1]) + 0.5, clipped)

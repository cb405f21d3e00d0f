"""Reader of barcodes on white boxes, from pixels alone (Section 3.3.3.2)."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.api.sensing import Image
from cbdsl_reproduction.chapter_3.barcode import Barcode

Floats = NDArray[np.float64]

# Least brightness of the box: that of the last of ten intensity channels.
_WHITE = 231
# Pixels darker than this share of the surrounding white belong to the print, including thin bars
# that the lens has made grey.
_PRINTED = 0.8
# Number of scan lines, samples along each, and margin as a share of the pattern's width.
_LINES, _SAMPLES, _MARGIN = 9, 1200, 0.05


def classify(image: Image, barcodes: Sequence[Barcode]) -> Barcode | None:
    """Return the candidate barcode that an image shows.

    Every scan line across the pattern becomes a string of intervals; the barcode with the lowest
    mean squared error to those strings wins.

    Args:
        image: RGB image of a white box, shape (height, width, 3).
        barcodes: Candidates.

    Returns:
        Barcode, or ``None`` if no pattern is found.
    """
    corners = find_pattern(image)
    if corners is None:
        return None
    strings = [intervals(line) for line in scan_lines(image, corners)]
    errors = [sum(mismatch(each, barcode) for each in strings) for barcode in barcodes]
    return barcodes[int(np.argmin(errors))]


def find_pattern(image: Image) -> Floats | None:
    """Return the corners of the print on the white box, px, shape (4, 2), clockwise from top left.

    The largest region of the brightest intensity channel is the box, and the dark pixels within
    its outline are the print. Pixel centres are at whole numbers.
    """
    brightness = cv2.GaussianBlur(image.max(axis=2), (3, 3), 0)
    white = cv2.inRange(brightness, _WHITE, 255)
    # The filled outline of the box includes its print, which is not white itself. Dark
    # pixels outside of the box, for example in the background, are thereby ignored.
    outlines, _ = cv2.findContours(white, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return None
    box = np.zeros_like(white)
    cv2.drawContours(box, [max(outlines, key=cv2.contourArea)], 0, 255, cv2.FILLED)
    level = float(np.median(brightness[(box > 0) & (white > 0)]))
    points = np.argwhere((box > 0) & (brightness < _PRINTED * level))[:, ::-1]
    if len(points) < 4:
        return None
    hull = cv2.convexHull(points.astype(np.int32))
    # A quadrilateral needs four corners; the hull of a single dark line, for example, has two.
    if len(hull) < 4:
        return None
    return _from_top_left(cv2.approxPolyN(hull, 4).reshape(4, 2).astype(np.float64))


def _from_top_left(corners: Floats) -> Floats:
    """Sort corners clockwise in the image, beginning with the one nearest to the top left."""
    offsets = corners - corners.mean(axis=0)
    clockwise = corners[np.argsort(np.arctan2(offsets[:, 1], offsets[:, 0]))]
    return np.roll(clockwise, -int(np.argmin(clockwise.sum(axis=1))), axis=0)


def scan_lines(image: Image, corners: Floats) -> Floats:
    """Return brightness along lines across the pattern, left to right, shape (lines, samples)."""
    left, right = -_MARGIN, 1 + _MARGIN
    columns = (np.array([0.0, 1, 1, 0]) - left) / (right - left) * _SAMPLES
    rows = np.array([0.0, 0, 1, 1]) * (_LINES + 1) - 1
    target = np.stack([columns, rows], axis=1).astype(np.float32)
    # The transform undoes the perspective, so that widths on a turned box keep their proportions.
    to_pattern = cv2.getPerspectiveTransform(corners.astype(np.float32), target)
    lines = cv2.warpPerspective(image.max(axis=2), to_pattern, (_SAMPLES, _LINES))
    return np.asarray(lines, dtype=np.float64)


def intervals(line: Floats) -> Floats:
    """Return widths of bar, gap, ..., bar along a scan line, as shares of their sum; may be empty.

    The threshold is halfway between the darkest and the brightest value; bars are darker.
    """
    black = line < (line.min() + line.max()) / 2
    edges = np.flatnonzero(np.diff(black.astype(np.int8), prepend=0, append=0))
    widths = np.diff(edges).astype(np.float64)
    shares: Floats = widths / widths.sum()
    return shares


def mismatch(perceived: Floats, barcode: Barcode) -> float:
    """Return the mean squared error between a string of intervals and a barcode.

    They are compared interval by interval; the shorter string is extended by intervals of zero
    width.
    """
    known = np.array(barcode.stripes) / sum(barcode.stripes)
    both = np.zeros((2, max(len(known), len(perceived))))
    both[0, : len(perceived)] = perceived
    both[1, : len(known)] = known
    return float(np.mean((both[0] - both[1]) ** 2))

"""Barcodes in synthetic images: read when turned, tilted, blurred and noisy."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from cbdsl_reproduction.chapter_3.barcode import SIZE, Barcode, barcodes
from cbdsl_reproduction.chapter_3.barcode_reader import classify, find_pattern, intervals, mismatch

BARCODES = [
    pytest.param(barcode, of_class, id=f"{frequency}-{barcode.name}")
    for frequency, of_class in barcodes().items()
    for barcode in of_class
]
# The printed side: 16 cm wide with the pattern in its middle, 10 samples per mm.
FINE, EDGE = 10_000, 0.16


def _side(barcode: Barcode) -> np.ndarray:
    side = np.full((round(EDGE * FINE),) * 2, 240, dtype=np.uint8)
    begin = round((EDGE - SIZE) / 2 * FINE)
    edges = begin + np.rint(np.cumsum([0.0, *barcode.stripes]) * FINE).astype(int)
    for left, right in zip(edges[:-1:2], edges[1::2], strict=True):
        side[begin : len(side) - begin, left:right] = 0
    return side


def _image(barcode: Barcode, corners: np.ndarray, blur: float, noise: float) -> np.ndarray:
    """Return a 640 x 480 image of the side with these corners, px, oversampled four times."""
    side, times = _side(barcode), 4
    size = len(side)
    source = np.array([[0, 0], [size, 0], [size, size], [0, size]], dtype=np.float32)
    to_image = cv2.getPerspectiveTransform(source, (times * corners).astype(np.float32))
    fine = cv2.warpPerspective(
        side, to_image, (640 * times, 480 * times), borderValue=180, flags=cv2.INTER_AREA
    )
    image = cv2.resize(
        cv2.GaussianBlur(fine, (0, 0), blur * times), (640, 480), interpolation=cv2.INTER_AREA
    )
    noisy = image + noise * np.random.default_rng(0).standard_normal(image.shape)
    return np.repeat(np.clip(noisy, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


def _corners(width: float, roll: float = 0.0, keystone: float = 0.0) -> np.ndarray:
    """Return corners of a ``width`` px square, turned by ``roll``, rad, and wider at the bottom."""
    half = width / 2
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    square[2:, 0] *= 1 + keystone
    turn = np.array([[np.cos(roll), -np.sin(roll)], [np.sin(roll), np.cos(roll)]])
    return square @ turn.T + [320.3, 239.6]


@pytest.mark.parametrize(("barcode", "of_class"), BARCODES)
@pytest.mark.parametrize("roll", [-0.25, 0.0, 0.1])
def test_resolved_barcode_is_classified_correctly(
    barcode: Barcode, of_class: tuple[Barcode, ...], roll: float
) -> None:
    image = _image(barcode, _corners(430, roll, keystone=0.05), blur=0.8, noise=5)
    assert classify(image, of_class) is barcode


@pytest.mark.parametrize("frequency", ["low", "medium", "high"])
def test_pattern_is_found_to_the_pixel(frequency: str) -> None:
    corners = _corners(300, roll=0.15, keystone=0.1)
    image = _image(barcodes()[frequency][1], corners, blur=0.8, noise=5)
    shown = np.array([[0, 0], [EDGE, 0], [EDGE, EDGE], [0, EDGE]], dtype=np.float32)
    to_image = cv2.getPerspectiveTransform(shown, corners.astype(np.float32))
    begin, end = (EDGE - SIZE) / 2, (EDGE + SIZE) / 2
    printed = np.array([[[begin, begin], [end, begin], [end, end], [begin, end]]])
    wanted = cv2.perspectiveTransform(printed.astype(np.float32), to_image)[0] - 0.5
    found = find_pattern(image)
    assert found is not None
    assert found == pytest.approx(wanted, abs=1.6)


def test_finer_patterns_need_a_nearer_look() -> None:
    """Accuracy falls with the size of the image, and first for the finest class."""
    read = {
        (frequency, width): sum(
            classify(_image(each, _corners(width, 0.05), 0.8, 5), of_class) is each
            for each in of_class
        )
        for frequency, of_class in barcodes().items()
        for width in (70, 400)
    }
    assert all(read[frequency, 400] == 3 for frequency in barcodes())
    assert read["low", 70] == 3
    assert read["high", 70] < 3


def test_image_without_a_white_box_or_a_print_has_no_barcode() -> None:
    candidates = barcodes()["low"]
    grey = np.full((480, 640, 3), 128, dtype=np.uint8)
    assert classify(grey, candidates) is None
    blank = grey.copy()
    blank[100:300, 100:300] = 245
    assert classify(blank, candidates) is None


def test_intervals_are_the_widths_from_the_first_bar_to_the_last() -> None:
    line = np.full(100, 200.0)
    line[10:20] = line[30:60] = 20.0
    assert intervals(line) == pytest.approx([0.2, 0.2, 0.6])
    assert len(intervals(np.full(100, 200.0))) == 0


def test_mismatch_is_zero_for_the_same_string_only() -> None:
    barcode, other = barcodes()["medium"][:2]
    own = np.array(barcode.stripes) / SIZE
    assert mismatch(own, barcode) == pytest.approx(0, abs=1e-12)
    assert mismatch(own, other) > 1e-5
    # A lost gap shifts everything after it.
    lost = np.concatenate([own[:5], [own[5:8].sum()], own[8:]])
    assert mismatch(lost, barcode) > 1e-5
    assert mismatch(np.empty(0), barcode) == pytest.approx(np.mean(own**2))

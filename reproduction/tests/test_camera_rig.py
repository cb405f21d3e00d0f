"""Camera rigs: boxes at the requested poses, rendered as the source's cameras would see them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from cbdsl_reproduction.chapter_3.barcode import SIZE, barcodes
from cbdsl_reproduction.chapter_3.barcode_reader import find_pattern
from cbdsl_reproduction.chapter_3.barcode_trial import FOCAL_LENGTH, BarcodeTrial
from cbdsl_reproduction.chapter_3.camera_rig import FINENESS, CameraRig, Placement, camera_rig
from cbdsl_reproduction.chapter_3.fig_3_6 import LENSES


@pytest.fixture(scope="module")
def place() -> Iterator[CameraRig]:
    with camera_rig() as place:
        yield place


def test_cameras_have_the_size_and_focal_length_of_the_source(place: CameraRig) -> None:
    for camera in place.robot.cameras.values():
        assert (camera.width, camera.height, camera.focal_length) == (640, 480, 837)
    assert place.baseline() == pytest.approx(0.3)


@pytest.mark.parametrize("placement", [Placement(1.0), Placement(0.5, left=0.04, up=-0.03)])
def test_pattern_is_drawn_at_its_pinhole_projection(place: CameraRig, placement: Placement) -> None:
    picture = place.picture(barcodes()["low"][0].stripes, placement)
    assert picture.shape == (480 * FINENESS, 640 * FINENESS, 3)
    corners = find_pattern(picture)
    assert corners is not None
    scale = FOCAL_LENGTH * FINENESS / placement.depth
    middle = np.array([320, 240]) * FINENESS - scale * np.array([placement.left, placement.up])
    assert corners.mean(axis=0) == pytest.approx(middle, abs=3)
    assert np.ptp(corners, axis=0) == pytest.approx(np.array([SIZE, SIZE]) * scale, rel=0.01)


def test_turned_box_is_foreshortened(place: CameraRig) -> None:
    square, turned = (
        find_pattern(place.picture(barcodes()["low"][0].stripes, Placement(0.75, turn=turn)))
        for turn in (0.0, 0.5)
    )
    assert square is not None
    assert turned is not None
    ratio = np.ptp(turned[:, 0]) / np.ptp(square[:, 0])
    assert ratio == pytest.approx(np.cos(0.5), rel=0.02)


@pytest.mark.parametrize("frequency", ["low", "medium"])
def test_resolved_barcode_is_read_through_the_lens(place: CameraRig, frequency: str) -> None:
    candidates = barcodes()[frequency]
    for seed, barcode in enumerate(candidates):
        picture = place.picture(barcode.stripes, Placement(0.5, turn=0.1))
        trial = BarcodeTrial(picture, FINENESS, 0.5, barcode, candidates, (seed,))
        assert all(trial.is_read(lens) for lens in LENSES.values())

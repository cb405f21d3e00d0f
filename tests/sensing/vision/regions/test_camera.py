"""Pinhole model: directions of pixels, and the limits of the image."""

import numpy as np
import pytest

from cbdsl.documents.robot import Camera
from cbdsl.sensing.vision.regions.camera import (
    direction,
    heading,
    heading_jacobian,
    line_of_sight,
    sight,
    within_view,
)

CAMERA = Camera(link="eye", width=320, height=240, focal_length=400)


def test_middle_of_the_image_is_straight_ahead() -> None:
    assert heading(sight(CAMERA, 160, 120)) == pytest.approx([0, 0])


def test_left_and_up_are_positive() -> None:
    azimuth, elevation = heading(sight(CAMERA, 100, 60))
    assert azimuth > 0 and elevation > 0


@pytest.mark.parametrize("seed", range(10))
def test_heading_inverts_direction(seed: int) -> None:
    angles = np.random.default_rng(seed).uniform(-1.2, 1.2, 2)
    assert heading(direction(angles)) == pytest.approx(angles)


@pytest.mark.parametrize("seed", range(10))
def test_heading_jacobian_by_finite_differences(seed: int) -> None:
    angles = np.random.default_rng(seed).uniform(-1.2, 1.2, 2)
    before, step = direction(angles), 1e-6
    columns = [
        (heading(before - np.cross(step * axis, before)) - angles) / step for axis in np.eye(3)
    ]
    assert heading_jacobian(angles) == pytest.approx(np.array(columns).T, abs=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_ball_is_within_view_if_its_image_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    column, row, distance = *rng.uniform(0, (320, 240)), rng.uniform(0.3, 2)
    radius = distance * rng.uniform(0.01, 0.2)
    room = min(column, row, 320 - column, 240 - row)
    whole = 400 * radius / distance < room
    assert within_view(CAMERA, distance * sight(CAMERA, column, row), radius) == whole
    assert not within_view(CAMERA, -distance * sight(CAMERA, column, row), radius)


def test_small_patch_off_axis_is_enlarged() -> None:
    # A small cone around any direction covers the same solid angle; its image does not.
    def image_area(column: float, row: float) -> float:
        centre = sight(CAMERA, column, row)
        centre /= np.linalg.norm(centre)
        across = np.linalg.svd(centre[None])[2][1:]
        rim = [
            centre + 1e-3 * (np.cos(t) * across[0] + np.sin(t) * across[1])
            for t in np.linspace(0, 2 * np.pi, 400)
        ]
        y, z = np.array([[r[1] / r[0], r[2] / r[0]] for r in rim]).T
        return float(abs(np.trapezoid(z, y)))

    ratio = image_area(20, 30) / image_area(160, 120)
    lens = np.array((CAMERA.width, CAMERA.height, CAMERA.focal_length), dtype=float)
    line = np.empty(3)
    length, scale = line_of_sight(lens, 20, 30, np.eye(3), line)
    assert line == pytest.approx(sight(CAMERA, 20, 30))
    assert length == pytest.approx(np.linalg.norm(line))
    assert ratio * scale == pytest.approx(1, rel=1e-3)

"""A ball between fingertips, and its image."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import Camera
from cbdsl_calibration.ball import centre, hidden, image, plane_of

EYE = Camera(link="eye", width=320, height=240, focal_length=400.0)


@pytest.mark.parametrize("seed", range(5))
def test_balls_centre_is_where_its_distances_meet(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tips, centres = rng.uniform(-0.1, 0.1, (8, 3, 3)), rng.uniform(-0.1, 0.1, (8, 3))
    for own, point in zip(tips, centres, strict=True):
        distances = np.linalg.norm(own - point, axis=1)
        side = np.sign(np.sum((point - own[0]) * plane_of(own[None])[2][0]))
        assert centre(own[None], distances, side)[0] == pytest.approx(point, abs=1e-9)


def test_image_of_a_ball_is_the_mean_of_its_pixels() -> None:
    point, radius = np.array((0.5, 0.08, -0.05)), 0.07
    columns, rows = np.meshgrid(np.arange(0.125, 320, 0.25), np.arange(0.125, 240, 0.25))
    sights = np.stack((np.ones_like(columns), (160 - columns) / 400, (120 - rows) / 400), axis=-1)
    along = sights @ point
    across = point @ point - along**2 / np.sum(sights**2, axis=-1)
    inside = across <= radius**2
    (centroid,), (area,) = image(EYE, point[None], radius)
    assert centroid == pytest.approx((columns[inside].mean(), rows[inside].mean()), abs=0.01)
    assert area == pytest.approx(inside.sum() / 16, rel=1e-3)


def test_hidden_part_shifts_the_centroid_away_from_the_nearest_fingertip() -> None:
    centroids, rim = np.array(((100.0, 80.0),)), np.array((50.0,))
    tips = np.array((((160.0, 80.0), (100.0, 140.0), (40.0, 80.0)),))
    distances = np.array(((0.5, 0.55, 0.56),))
    shift = hidden(centroids, np.array((0.98,)), tips, distances, rim)
    assert shift[0] == pytest.approx((-1.0, 0.0), abs=1e-3)
    assert hidden(centroids, np.array((1.02,)), tips, distances, rim)[0] == pytest.approx((0, 0))

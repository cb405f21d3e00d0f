"""Ideal cameras measure regions as well as rendered ones do, and no better."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.cameras.ideal import RegionErrors
from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.channels import ChannelFilter, Region
from tests.backends.conftest import URDF, made_stage

CHANNEL = "hue_1"
EPISODES = 40


def errors(dexter: RobotDocument, cameras: str, radius: float) -> np.ndarray:
    """Return standard deviations of the area, as a share of it, and of column and row, px."""
    backend = BulletBackend(dexter, URDF, cameras=cameras)
    images = ChannelFilter(dexter.vision.channels, (CHANNEL,), 12)
    rng, measured = np.random.default_rng(1), []
    camera = dexter.cameras["left"]
    for episode in range(EPISODES):
        aside, ahead = rng.uniform(-0.004, 0.004, 2).tolist()
        place = {"x": 0.6 + ahead, "y": aside, "z": -0.2, "held": True}
        form = {"shape": "ball", "radius": radius}
        ball = {"form": form, "mass": 0.25, "color": [1, 0, 0]}
        context = {"things": ["ball"], "place": place, "joints": {"pan": 0.0, "tilt": 1.0}}
        stage = made_stage(context, things={"ball": ball})
        backend.reset(stage, None, np.random.default_rng(episode))
        seen = backend.observe()
        regions = seen.regions.get("left") or images.regions(seen.images["left"])
        region: Region = regions[CHANNEL][0]
        eye = backend.truth.link_pose(camera.link)
        x, y, z = eye.rotation.T @ (backend.truth.pose("ball").position - eye.position)
        square = x * x + y * y + z * z
        column = camera.width / 2 - camera.focal_length * y / x
        row = camera.height / 2 - camera.focal_length * z / x
        measured.append((region.area * square, region.column - column, region.row - row))
    backend.close()
    deviations = np.std(measured, axis=0)
    relative: np.ndarray = deviations / [np.mean(measured, axis=0)[0], 1.0, 1.0]
    return relative


@pytest.mark.parametrize("radius", [0.03, 0.06])
@pytest.mark.usefixtures("opengl")
def test_errors_of_ideal_cameras_are_within_a_factor_of_two_of_rendered_ones(
    dexter: RobotDocument, radius: float
) -> None:
    ratio = errors(dexter, "ideal", radius) / errors(dexter, "rendered", radius)
    assert (ratio > 0.5).all() and (ratio < 2.0).all()


def test_errors_grow_with_the_noise_and_small_regions_suffer_most() -> None:
    def spread(deviation: float, area: float) -> np.ndarray:
        noise = RegionErrors(deviation, np.random.default_rng(0))
        drawn = np.array([noise.added(area, 0.0, 0.0) for _ in range(2000)])
        relative: np.ndarray = drawn.std(axis=0) / [area, 1.0, 1.0]
        return relative

    assert spread(4.0, 300.0) == pytest.approx(2 * spread(2.0, 300.0), rel=1e-9)
    assert (spread(2.0, 50.0) > 1.2 * spread(2.0, 500.0)).all()
    assert not spread(0.0, 300.0).any()


def test_region_keeps_a_pixel() -> None:
    noise = RegionErrors(30.0, np.random.default_rng(0))
    assert min(noise.added(1.0, 0.0, 0.0)[0] for _ in range(500)) == 1.0

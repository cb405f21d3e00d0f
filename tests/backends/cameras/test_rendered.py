"""Imperfect cameras: how far off they are, and how noisy."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from tests.backends.conftest import made_stage


def test_cameras_are_off_by_the_stated_distance_and_angle(bullet: BulletBackend) -> None:
    errors = []
    for seed in range(3):
        disturbance = {"camera_position": 0.002, "camera_rotation": 0.01}
        stage = made_stage({}, disturbance=disturbance)
        bullet.reset(stage, None, np.random.default_rng(seed))
        for name, view in bullet.cameras.views().items():
            believed = bullet.truth.link_pose(f"{name}_camera")
            offset = view.pose.position - believed.position
            turn = believed.rotation.T @ view.pose.rotation
            assert np.linalg.norm(offset) == pytest.approx(0.002)
            assert np.arccos((np.trace(turn) - 1) / 2) == pytest.approx(0.01, rel=1e-3)
            errors.append(tuple(np.round(offset, 9)))
    assert len(set(errors)) == len(errors), "every camera errs in its own way in every episode"


def test_cameras_are_where_the_model_has_them_without_disturbance(
    bullet: BulletBackend,
) -> None:
    bullet.reset(made_stage({}), None, np.random.default_rng(0))
    for name, view in bullet.cameras.views().items():
        believed = bullet.truth.link_pose(f"{name}_camera")
        assert view.pose.position == pytest.approx(believed.position)
        assert view.pose.rotation == pytest.approx(believed.rotation)


def test_image_noise_has_the_stated_deviation(bullet: BulletBackend) -> None:
    bullet.reset(made_stage({}), None, np.random.default_rng(0))
    clean = bullet.observe().images["left"].astype(float)
    noisy_stage = made_stage({}, disturbance={"image_noise": 4})
    bullet.reset(noisy_stage, None, np.random.default_rng(0))
    noise = bullet.observe().images["left"] - clean
    inside = (clean > 30) & (clean < 225)
    assert noise[inside].std() == pytest.approx(4, rel=0.05)
    assert noise[inside].mean() == pytest.approx(0, abs=0.1)

"""Imperfect cameras: how far off they are, and how noisy."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.calibration import with_corrections
from cbdsl.documents.robot import Correction, RobotDocument
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


def test_body_keeps_its_cameras_in_all_episodes_and_stages(bullet: BulletBackend) -> None:
    def offsets(body: int, seed: int, noise: float) -> np.ndarray:
        disturbance = {"camera_position": 0.002, "body": body, "image_noise": noise}
        bullet.reset(made_stage({}, disturbance=disturbance), None, np.random.default_rng(seed))
        views = bullet.cameras.views()
        return np.array(
            [
                v.pose.position - bullet.truth.link_pose(f"{n}_camera").position
                for n, v in views.items()
            ]
        )

    first = offsets(3, 0, 0.0)
    assert offsets(3, 1, 2.0) == pytest.approx(first)
    assert np.abs(offsets(4, 0, 0.0) - first).max() > 1e-4


def test_calibration_of_a_robot_changes_no_image(
    dexter: RobotDocument, urdf: Path, bullet: BulletBackend
) -> None:
    known = dict.fromkeys(dexter.cameras, Correction(position=(0.1, 0.0, 0.0)))
    corrected = BulletBackend(with_corrections(dexter, known), urdf)
    images = []
    for backend in (bullet, corrected):
        backend.reset(made_stage({}), None, np.random.default_rng(0))
        images.append(backend.observe().images["left"])
    corrected.close()
    assert (images[0] == images[1]).all()


def test_cameras_without_disturbance_have_the_poses_of_the_model(
    bullet: BulletBackend,
) -> None:
    bullet.reset(made_stage({}), None, np.random.default_rng(0))
    for name, view in bullet.cameras.views().items():
        believed = bullet.truth.link_pose(f"{name}_camera")
        assert view.pose.position == pytest.approx(believed.position)
        assert view.pose.rotation == pytest.approx(believed.rotation)


def test_image_noise_has_the_stated_deviation(bullet: BulletBackend) -> None:
    """Noise of the sensor and noise of the stage add up."""
    bullet.reset(made_stage({}), None, np.random.default_rng(0))
    clean = bullet.cameras.render(bullet.cameras.views())["left"].astype(float)
    noisy_stage = made_stage({}, disturbance={"image_noise": 4})
    bullet.reset(noisy_stage, None, np.random.default_rng(0))
    noise = bullet.observe().images["left"] - clean
    inside = (clean > 30) & (clean < 225)
    own = bullet._robot.vision.noise
    assert own > 1 and noise[inside].std() == pytest.approx(math.hypot(4, own), rel=0.05)
    assert noise[inside].mean() == pytest.approx(0, abs=0.1)

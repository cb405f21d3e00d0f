"""Cameras after the light went out."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from tests.backends.conftest import URDF, exact, made_stage, run

BALL = {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.25, "color": [1, 0, 0]}
SHOWN = {"things": ["ball"], "place": {"x": 0.6, "z": -0.2, "held": True}}
AHEAD = {"pan": 0.0, "tilt": 1.0}


def test_images_are_black_after_dark_after(rendered: BulletBackend) -> None:
    stage = made_stage({**SHOWN, "joints": AHEAD, "dark_after": 0.2}, things={"ball": BALL})
    rendered.reset(stage, None, np.random.default_rng(0))
    assert all(image.max() > 100 for image in rendered.observe().images.values())
    run(rendered, 0.3)
    while not rendered.observe().images:
        rendered.step()
    images = rendered.observe().images
    assert {image.shape for image in images.values()} == {(240, 320, 3)}
    assert not any(image.any() for image in images.values())


def test_ideal_cameras_report_no_regions_in_the_dark(dexter: RobotDocument) -> None:
    backend = KinematicBackend(exact(dexter), URDF)
    stage = made_stage({**SHOWN, "joints": AHEAD, "dark_after": 0.2}, things={"ball": BALL})
    backend.reset(stage, None, np.random.default_rng(0))
    assert all(backend.observe().regions[camera] for camera in dexter.cameras)
    run(backend, 0.3)
    while not backend.observe().regions:
        backend.step()
    assert not any(backend.observe().regions[camera] for camera in dexter.cameras)
    backend.close()


@pytest.mark.parametrize("cameras", ["rendered", "ideal"])
def test_dark_after_zero_is_dark_from_the_start(dexter: RobotDocument, cameras: str) -> None:
    backend = BulletBackend(exact(dexter), URDF, cameras=cameras)
    stage = made_stage({**SHOWN, "joints": AHEAD, "dark_after": 0.0}, things={"ball": BALL})
    backend.reset(stage, None, np.random.default_rng(0))
    observation = backend.observe()
    assert not any(image.any() for image in observation.images.values())
    assert not any(observation.regions.get(camera) for camera in dexter.cameras)
    backend.close()

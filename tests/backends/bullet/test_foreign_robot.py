"""A robot that is not Dexter: an arm of meshes, without hands, passive joints or cameras."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pybullet_data
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.cameras.view import View
from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl_mujoco.backend import MujocoBackend

URDF = Path(pybullet_data.getDataPath()) / "kuka_iiwa" / "model.urdf"
HOME = (0.0, 0.5, 0.0, -1.0, 0.0, 1.0, 0.0)
CAMERA = {"link": "lbr_iiwa_link_7", "width": 64, "height": 48, "focal_length": 60}
STAGE = StageDocument.model_validate(
    {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": "iiwa", "contexts": {"empty": {}}}
)


def make(**more: Any) -> RobotDocument:
    arm: Mapping[str, Any] = {
        "joints": [f"lbr_iiwa_joint_{number}" for number in range(1, 8)],
        "postures": {"home": HOME},
        "start": "home",
    }
    return RobotDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "robot",
            "name": "iiwa",
            "model": str(URDF),
            "base": "lbr_iiwa_link_0",
            "effectors": {"arm": arm},
            "control": {"rate": 60, "tasks": {}},
            **more,
        }
    )


def test_foreign_robot_reaches_its_references() -> None:
    backend = BulletBackend(make(), URDF)
    backend.reset(STAGE, None, np.random.default_rng(0))
    assert backend.renderer == "none (no cameras)"
    assert backend.observe().positions == pytest.approx(HOME)
    target = np.array(HOME) + 0.2
    for _ in range(120):
        backend.apply(target)
        backend.step()
    observation = backend.observe()
    assert observation.positions == pytest.approx(target, abs=0.01)
    assert not observation.images
    backend.close()


@pytest.mark.usefixtures("opengl")
def test_robot_of_meshes_has_the_same_silhouette_in_every_renderer() -> None:
    camera = Camera(link="lbr_iiwa_link_0", width=160, height=160, focal_length=150)
    view = View(camera, Pose(np.array([-2.0, 0.0, 0.6]), np.eye(3)))
    masks = {}
    for engine, renderer in (
        (BulletBackend, "auto"),
        (BulletBackend, "tiny"),
        (MujocoBackend, "auto"),
    ):
        robot = make(cameras={"eye": CAMERA}, vision={"renderer": renderer})
        backend = engine(robot, URDF, cameras="rendered")
        backend.reset(STAGE, None, np.random.default_rng(0))
        assert backend.renderer.startswith("tiny" if renderer == "tiny" else "opengl")
        image = backend.cameras.render({"eye": view})["eye"].astype(int)
        masks[engine, renderer] = np.abs(image - 199).max(axis=2) > 4
        backend.close()
    for mask in masks.values():
        expected = masks[BulletBackend, "tiny"]
        assert (mask & expected).sum() > 0.94 * (mask | expected).sum() > 500

"""A robot that is not Dexter: an arm of meshes, without hands, passive joints or cameras."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pybullet_data
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument

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


def test_meshes_are_left_to_the_simulators_own_renderer() -> None:
    backend = BulletBackend(make(cameras={"eye": CAMERA}), URDF)
    backend.reset(STAGE, None, np.random.default_rng(0))
    assert backend.renderer.startswith("tiny")
    assert backend.observe().images["eye"].shape == (48, 64, 3)
    backend.close()
    with pytest.raises(BackendError, match="only balls, boxes and cylinders"):
        BulletBackend(make(cameras={"eye": CAMERA}, vision={"renderer": "opengl"}), URDF)

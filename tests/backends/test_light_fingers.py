"""Grippers whose inner fingers are light and follow the outer ones: they press, and do not bend."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Surface
from cbdsl.kinematics.pose import Pose
from tests.backends.conftest import BACKENDS

#: Outer fingers of 6 cm that open at their base, and inner ones of 3 g that stay parallel.
SIDE = """
  <link name="{side}_outer">
    <inertial><origin xyz="0 0 0.03"/><mass value="0.05"/>
      <inertia ixx="2e-5" iyy="2e-5" izz="5e-6" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="{side}_inner">
    <inertial><origin xyz="0 0 0.02"/><mass value="0.003"/>
      <inertia ixx="4e-7" iyy="4e-7" izz="1e-7" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.03"/><geometry><box size="0.02 0.01 0.03"/></geometry></collision>
  </link>
  <joint name="{side}" type="revolute">
    <parent link="base"/><child link="{side}_outer"/>
    <origin xyz="0 {y} 0"/><axis xyz="{x} 0 0"/>
    <limit lower="0" upper="0.8" effort="{effort}" velocity="2"/>{mimic}
  </joint>
  <joint name="{side}_follower" type="revolute">
    <parent link="{side}_outer"/><child link="{side}_inner"/>
    <origin xyz="0 0 0.06"/><axis xyz="{x} 0 0"/>
    <limit lower="-0.9" upper="0.9" effort="1000" velocity="2"/>
    <mimic joint="left" multiplier="-1"/>
  </joint>"""


def gripper(folder: Path, effort: float) -> Path:
    left = SIDE.format(side="left", y="0.05", x="1", effort=effort, mimic="")
    right = SIDE.format(side="right", y="-0.05", x="-1", effort=1000, mimic='<mimic joint="left"/>')
    file = folder / "gripper.urdf"
    file.write_text(f'<robot name="gripper"><link name="base"/>{left}{right}</robot>')
    return file


def document(file: Path) -> RobotDocument:
    cells = {
        side: {"link": f"{side}_inner", "joint": "left", "normal": [0, normal, 0]}
        for side, normal in (("left", -1), ("right", 1))
    }
    pads = {"links": ["left_inner", "right_inner"], "stiffness": 3000, "damping": 60}
    followers = {"left_follower": -1, "right": 1, "right_follower": -1}
    return RobotDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "robot",
            "name": "gripper",
            "model": str(file),
            "base": "base",
            "effectors": {"hand": {"joints": ["left"]}},
            "couplings": {name: {"follows": "left", "ratio": r} for name, r in followers.items()},
            "load_cells": {"hand": cells},
            "control": {"rate": 60, "tasks": {}},
            "simulation": {"surfaces": [pads]},
        }
    )


@pytest.mark.parametrize("effort", [2.0, 5.0])
@pytest.mark.parametrize("name", ["bullet", "mujoco"])
def test_light_fingers_press_with_the_effort_of_their_drive(
    name: str, effort: float, tmp_path: Path
) -> None:
    file = gripper(tmp_path, effort)
    backend = BACKENDS[name](document(file), file)
    truth, dt = backend.truth, 1 / 240
    truth.begin(np.zeros(1))
    # Between pads that are 9 cm apart when open, at the height of both.
    block = SolidShape("box", (0.02, 0.025, 0.03))
    truth.add(SceneObject("block", block, Surface(), 0.0, Pose(np.array([0, 0, 0.09]), np.eye(3))))
    reference = 0.0
    for _ in range(480):
        # As a controller of force does, the reference leads by a bounded angle.
        reference = min(reference + dt, float(truth.read()[0][0]) + 0.12)
        truth.step(np.array([reference]))
    tilts = {side: _tilt(truth.link_pose(f"{side}_inner")) for side in ("left", "right")}
    opened = {side: _tilt(truth.link_pose(f"{side}_outer")) for side in ("left", "right")}
    forces = np.linalg.norm(truth.wrenches()[:, :3], axis=1)
    backend.close()
    assert 0.2 < opened["left"] < 0.6, "the pads are at the block"
    assert opened["right"] == pytest.approx(-opened["left"], abs=0.06)
    assert tilts == pytest.approx({"left": 0.0, "right": 0.0}, abs=0.06)
    # Two fingers share the effort, with a lever of about 6 cm.
    assert forces.sum() == pytest.approx(effort / 0.058, rel=0.35)
    assert forces.min() > 2.0


def _tilt(pose: Pose) -> float:
    """Return the angle of a link about the x axis, rad."""
    return float(np.arctan2(pose.rotation[2, 1], pose.rotation[1, 1]))

"""Obstructions of joints that do not follow: weights beyond efforts, and contacts of own links."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.actuation import obstructions

_LINK = (
    '<link name="{}"><collision><geometry><box size="0.4 0.1 0.1"/></geometry>'
    '<origin xyz="0.2 0 0"/></collision><inertial><origin xyz="0.2 0 0"/><mass value="2"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
_JOINT = (
    '<joint name="{0}_joint" type="revolute"><parent link="base"/><child link="{0}"/>'
    '<origin xyz="0 {1} 0"/><axis xyz="{2}"/>'
    '<limit lower="-3" upper="3" effort="{3}" velocity="1"/></joint>'
)
_ARMS = (("left", 0.3, "0 0 1", 10), ("right", -0.3, "0 0 1", 10), ("lift", 2.0, "0 1 0", 3))


@pytest.fixture
def model(tmp_path: Path) -> UrdfModel:
    links = "".join(_LINK.format(name) for name, *_ in _ARMS)
    joints = "".join(_JOINT.format(*arm) for arm in _ARMS)
    text = f"<robot name='m'><link name='base'/>{links}{joints}</robot>"
    path = tmp_path / "arms.urdf"
    path.write_text(text, "utf-8")
    return read_urdf(path)


def robot(*no_contact: tuple[str, ...]) -> RobotDocument:
    effectors = {
        name: {"joints": [f"{name}_joint"], "postures": {"start": [0]}, "start": "start"}
        for name, *_ in _ARMS
    }
    return RobotDocument.model_validate(
        {
            "cbdsl": 1, "kind": "robot", "name": "arms", "model": "arms.urdf", "base": "base",
            "effectors": effectors, "simulation": {"no_contact": no_contact},
            "control": {"rate": "60 Hz", "joint_speed": "1 rad/s", "limit_margin": 0, "tasks": {}},
        }
    )  # fmt: skip


def test_weight_beyond_an_effort_is_named_with_both(model: UrdfModel) -> None:
    assert obstructions(robot(), model, {}, ["lift_joint"]) == ("lift_joint bears 3.92 of 3 N m",)
    assert obstructions(robot(), model, {"lift_joint": 1.5}, ["lift_joint"]) == ()


def test_contact_of_own_links_is_named_for_the_joints_that_move_them(model: UrdfModel) -> None:
    crossed = {"left_joint": -1.5, "right_joint": 1.5}
    found = ("left touches right",)
    assert obstructions(robot(), model, crossed, ["left_joint"]) == found
    assert obstructions(robot(("left", "right")), model, crossed, ["left_joint"]) == ()
    assert obstructions(robot(), model, {**crossed, "lift_joint": 1.5}, ["lift_joint"]) == ()
    assert obstructions(robot(), model, {}, ["left_joint"]) == ()

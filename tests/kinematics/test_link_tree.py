"""Compiled and interpreted forward kinematics place each link of a shipped robot alike."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.robot.urdf_reader import read_urdf
from tests.backends.conftest import LIBRARY, ROOT


@pytest.mark.parametrize("name", LIBRARY.names(RobotDocument))
def test_links_of_a_shipped_robot_have_one_place(name: str) -> None:
    robot = LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document
    urdf = ROOT / "robots" / robot.model
    kinematics, model = Kinematics(robot, urdf), read_urdf(urdf)
    compiled = LinkTree(model, kinematics.joints, robot.base)
    interpreted, joints = JointTree(model.beyond(robot.base)), kinematics.joints
    rng = np.random.default_rng(0)
    for _ in range(10):
        angles = rng.uniform(kinematics.lower, kinematics.upper)
        compiled.update(angles)
        kinematics.update(angles)
        positions = dict(zip(joints.all, joints.expand(angles).tolist(), strict=True))
        placed = interpreted.place({**model.rests, **positions})
        assert placed.keys() | {robot.base} == compiled.rows.keys()
        for link in placed:
            frame = kinematics.frame(link)
            for pose in (compiled.pose(link), placed[link].child):
                assert pose.position == pytest.approx(frame.position, abs=1e-12)
                assert pose.rotation == pytest.approx(frame.rotation, abs=1e-12)

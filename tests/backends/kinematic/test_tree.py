"""One pass over all links puts each where the robot's kinematics have it."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.kinematic.tree import Tree
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.urdf_reader import read_urdf
from tests.backends.conftest import LIBRARY, ROOT


@pytest.mark.parametrize("name", LIBRARY.names(RobotDocument))
def test_links_are_where_the_kinematics_have_them(name: str) -> None:
    robot = LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document
    urdf = ROOT / "robots" / robot.model
    kinematics = Kinematics(robot, urdf)
    tree = Tree(read_urdf(urdf), kinematics.joints, robot.base)
    rng = np.random.default_rng(0)
    for _ in range(10):
        angles = rng.uniform(kinematics.lower, kinematics.upper)
        tree.update(angles)
        kinematics.update(angles)
        for link in tree.rows:
            frame = kinematics.frame(link)
            assert tree.pose(link).position == pytest.approx(frame.position, abs=1e-12)
            assert tree.pose(link).rotation == pytest.approx(frame.rotation, abs=1e-12)

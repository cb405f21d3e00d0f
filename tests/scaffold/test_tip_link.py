"""Tips of arms with cameras: at the far end of the hand, with z away from the arm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cbdsl
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import Library

LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="1"/>'


def arm(hand: str) -> str:
    """Return an arm of three joints whose last link has a shape."""
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="0 0 0.4"/><axis xyz="{axis}"/>{LIMIT}</joint>'
        for i, axis in enumerate(("0 0 1", "0 1 0", "0 1 0"))
    )
    tool = '<joint name="t" type="fixed"><parent link="l3"/><child link="tool0"/></joint>'
    shape = f"<collision>{hand}</collision>"
    links = "".join(f'<link name="l{i}">{shape if i == 3 else ""}</link>' for i in range(4))
    return f'<robot name="arm">{links}<link name="tool0"/>{joints}{tool}</robot>'


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_tip_is_at_the_far_end_of_a_hand_along_any_axis(
    axis: int, sign: int, tmp_path: Path
) -> None:
    place, size = np.zeros(3), np.full(3, 0.06)
    place[axis], size[axis] = sign * 0.1, 0.2
    texts = (" ".join(map(str, row)) for row in (place, size))
    box = '<origin xyz="{}"/><geometry><box size="{}"/></geometry>'.format(*texts)
    (tmp_path / "arm.urdf").write_text(arm(box))
    cbdsl.propose_robot("mine", tmp_path / "arm.urdf", to=tmp_path / "robots", cameras=True)
    robot = Library().read(tmp_path / "robots" / "mine.yaml", RobotDocument).document
    model = read_urdf(tmp_path / "robots" / robot.model)
    placed = JointTree(j for root in model.roots for j in model.beyond(root)).place(model.rests)
    ((name, tip),) = ((name, each.tip) for name, each in robot.effectors.items() if each.tip)
    assert tip is not None and tip.link == f"{name}_tip" and not any(tip.offset)
    frame, flange = placed[tip.link].child, placed["tool0"].child
    outwards = flange.rotation[:, axis] * sign
    assert frame.rotation[:, 2] == pytest.approx(outwards, abs=1e-6)
    assert frame.position == pytest.approx(flange.position + 0.2 * outwards, abs=1e-3)
    # The gap is that of the arm's length alone, since nothing is beyond the tip.
    assert float(robot.effectors[name].values["gap"].split()[0]) < 3


def test_a_flat_flange_keeps_its_own_frame(tmp_path: Path) -> None:
    flange = '<origin xyz="0.01 0 0"/><geometry><box size="0.08 0.08 0.02"/></geometry>'
    (tmp_path / "arm.urdf").write_text(arm(flange))
    cbdsl.propose_robot("mine", tmp_path / "arm.urdf", to=tmp_path / "robots", cameras=True)
    robot = Library().read(tmp_path / "robots" / "mine.yaml", RobotDocument).document
    assert {each.tip.link for each in robot.effectors.values() if each.tip} == {"tool0"}

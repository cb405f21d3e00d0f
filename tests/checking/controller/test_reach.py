"""The bound on a tip's distance, which holds in every posture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import shipped


@pytest.mark.parametrize("name", ["dexter", "sixaxis", "desk"])
def test_no_tip_gets_farther_than_its_links_are_long(name: str) -> None:
    body = Session().body(shipped() / "robots" / f"{name}.yaml", Diagnostics())
    assert body is not None and body.model is not None
    robot, model = body.document, body.model
    kinematics = Kinematics(robot, shipped() / "robots" / robot.model)
    tips = [effector.tip for effector in robot.effectors.values() if effector.tip is not None]
    assert tips
    rng = np.random.default_rng(1)
    for _ in range(200):
        kinematics.update(rng.uniform(kinematics.lower, kinematics.upper))
        for tip in tips:
            reach = model.reach(robot.base, tip.link)
            assert reach is not None
            distance = np.linalg.norm(kinematics.frame(tip.link).position)
            assert distance <= reach + 1e-9


def test_reach_of_a_sliding_joint_includes_its_limits(tmp_path: Path) -> None:
    limit = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
    joints = "".join(
        f'<joint name="{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 3 4"/>{limit}</joint>'
        for kind, parent, child in (
            ("revolute", "base", "arm"),
            ("prismatic", "arm", "rail"),
            ("revolute", "base", "other"),
        )
    )
    links = "".join(f'<link name="{name}"/>' for name in ("base", "arm", "rail", "other"))
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="robot">{links}{joints}</robot>', encoding="utf-8")
    model = read_urdf(path)
    assert model.reach("base", "arm") == 5
    assert model.reach("arm", "other") == 10
    assert model.reach("other", "other") == 0
    assert model.reach("base", "rail") == 11

"""Proposed tips: frames that models provide for tools, or the far end of the last link."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.robot.chains import chains
from cbdsl.robot.tip_frame import tip_offset
from cbdsl.robot.urdf_reader import read_urdf
from tests.robot.test_chains import read

LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def _written(folder: Path, fixed: dict[str, str], shape: str = "") -> Path:
    """Write a model of one joint, with links that are fixed to others."""
    names = "".join(f'<link name="{name}"/>' for name in ("base", *fixed))
    joints = "".join(
        f'<joint name="to_{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
        "</joint>"
        for child, parent in fixed.items()
    )
    path = folder / "model.urdf"
    path.write_text(
        f'<robot name="m">{names}<link name="wrist">{shape}</link>{joints}<joint name="turn" '
        f'type="revolute"><parent link="base"/><child link="wrist"/>{LIMIT}</joint></robot>'
    )
    return path


@pytest.mark.parametrize(
    ("fixed", "tip"),
    [
        ({}, "wrist"),
        ({"flange": "wrist"}, "flange"),
        ({"flange": "wrist", "tool0": "flange"}, "tool0"),
        ({"camera": "wrist", "tcp": "wrist", "screw": "wrist"}, "tcp"),
        ({"tcp": "wrist", "tool0": "tcp"}, "tcp"),
        ({"tool0": "wrist", "tool": "wrist"}, "tool0"),
        ({"camera_link": "wrist", "flange": "wrist"}, "flange"),
        ({"gripper_base": "wrist", "tcp": "gripper_base"}, "tcp"),
        ({"left_screw": "wrist", "right_screw": "wrist"}, "wrist"),
    ],
)
def test_tip_is_the_frame_with_a_usual_name(
    fixed: dict[str, str], tip: str, tmp_path: Path
) -> None:
    (chain,) = chains(read_urdf(_written(tmp_path, fixed)))
    assert chain.tip == tip


def test_tip_is_a_frame_beside_the_link_that_carries_the_fingers(tmp_path: Path) -> None:
    path = _written(tmp_path, {"tool0": "wrist", "tcp": "tool0", "palm_body": "tool0"})
    fingers = "".join(
        f'<link name="{side}_finger"/><joint name="{side}" type="prismatic"><parent '
        f'link="palm_body"/><child link="{side}_finger"/>{LIMIT}</joint>'
        for side in ("left", "right")
    )
    path.write_text(path.read_text().replace("</robot>", f"{fingers}</robot>"))
    arm, hand = chains(read_urdf(path))
    assert (arm.tip, arm.others, hand.tip) == ("tcp", ("tool0",), None)
    assert [joint.name for joint in hand.joints] == ["left", "right"]


@pytest.mark.parametrize(
    ("shape", "offset"),
    [
        ("", (0, 0, 0)),
        (
            '<collision><origin xyz="0 0 -0.1"/><geometry><box size="0.02 0.02 0.2"/></geometry>'
            "</collision>",
            (0, 0, -0.2),
        ),
        (
            '<visual><origin xyz="0.1 0 0" rpy="0 1.5707963 0"/><geometry>'
            '<cylinder radius="0.01" length="0.2"/></geometry></visual>',
            (0.2, 0, 0),
        ),
        ('<visual><geometry><sphere radius="0.1"/></geometry></visual>', (0, 0, 0)),
    ],
)
def test_without_such_a_frame_the_tip_is_the_far_end_of_the_link(
    shape: str, offset: tuple[float, ...], tmp_path: Path
) -> None:
    model = read_urdf(_written(tmp_path, {}, shape))
    (chain,) = chains(model)
    assert tip_offset(model, chain.joints[-1], chain.tip) == pytest.approx(offset, abs=1e-6)


def test_link_of_a_mesh_ends_where_that_does() -> None:
    model = read("kuka_iiwa/model.urdf")
    (chain,) = chains(model)
    assert tip_offset(model, chain.joints[-1], chain.tip) == pytest.approx((0, 0, 0.045), abs=2e-3)

"""Dexter's model fits its robot file, and comes from its script."""

from __future__ import annotations

import runpy
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.joints import Joints
from cbdsl.yaml_text.library import Library

ROOT = Path(__file__).parents[2]
URDF = ROOT / "robots" / "dexter.urdf"


@pytest.fixture(scope="module")
def dexter() -> RobotDocument:
    library = Library(ROOT)
    return library.read(library.locate(RobotDocument, "dexter"), RobotDocument).document


@pytest.fixture(scope="module")
def model() -> ET.Element:
    return ET.parse(URDF).getroot()


def _names(model: ET.Element, kind: str) -> set[str]:
    return {element.attrib["name"] for element in model.findall(kind)}


def test_model_equals_the_output_of_its_script() -> None:
    script = runpy.run_path(str(ROOT / "robots" / "make_dexter.py"))
    assert URDF.read_text(encoding="utf-8") == script["dexter"]()


def test_robot_file_names_all_and_only_the_movable_joints(
    model: ET.Element, dexter: RobotDocument
) -> None:
    movable = {
        joint.attrib["name"]
        for joint in model.findall("joint")
        if joint.attrib["type"] == "revolute"
    }
    joints = Joints(dexter)
    assert movable == set(joints.all)
    assert len(joints) == 24


def test_every_link_that_the_robot_file_names_exists(
    model: ET.Element, dexter: RobotDocument
) -> None:
    named = {dexter.base}
    named |= {effector.tip.link for effector in dexter.effectors.values() if effector.tip}
    named |= {cell.link for hand in dexter.load_cells.values() for cell in hand.values()}
    named |= {camera.link for camera in dexter.cameras.values()}
    assert named <= _names(model, "link")


def test_mimic_tags_equal_the_couplings(model: ET.Element, dexter: RobotDocument) -> None:
    mimics = {
        joint.attrib["name"]: (tag.attrib["joint"], float(tag.attrib["multiplier"]))
        for joint in model.findall("joint")
        if (tag := joint.find("mimic")) is not None
    }
    assert mimics.keys() == dexter.couplings.keys()
    for name, coupling in dexter.couplings.items():
        followed, ratio = mimics[name]
        assert followed == coupling.follows
        assert ratio == pytest.approx(coupling.ratio, rel=1e-6)


def test_postures_are_within_the_limits(model: ET.Element, dexter: RobotDocument) -> None:
    limits = {
        joint.attrib["name"]: [float(tag.attrib[end]) for end in ("lower", "upper")]
        for joint in model.findall("joint")
        if (tag := joint.find("limit")) is not None
    }
    for effector in dexter.effectors.values():
        for posture in effector.postures.values():
            for joint, angle in zip(effector.joints, posture, strict=True):
                assert limits[joint][0] <= angle <= limits[joint][1], joint


def test_body_is_grey(model: ET.Element) -> None:
    colors = [color.attrib["rgba"].split()[:3] for color in model.iter("color")]
    assert colors
    assert all(len(set(color)) == 1 for color in colors)


def test_lines_of_sight_meet_in_front_of_the_head(dexter: RobotDocument) -> None:
    kinematics = Kinematics(dexter, URDF)
    kinematics.update(np.zeros(24))
    left, right = kinematics.frame("left_camera"), kinematics.frame("right_camera")
    assert left.position - right.position == pytest.approx([0, 0.30, 0])
    ahead = 0.15 / np.tan(0.15)
    for frame in (left, right):
        along = frame.rotation[:, 0]
        crossing = frame.position + along * ahead / along[0]
        assert crossing[1:] == pytest.approx([0, left.position[2]])


def test_arms_start_as_mirror_images(dexter: RobotDocument) -> None:
    kinematics = Kinematics(dexter, URDF)
    joints = Joints(dexter)
    positions = np.zeros(len(joints))
    for side in ("left_arm", "right_arm"):
        positions[joints.of(side)] = dexter.effectors[side].postures["home"]
    kinematics.update(positions)
    left, right = (kinematics.frame(f"{side}_palm") for side in ("left", "right"))
    assert left.position == pytest.approx(right.position * [1, -1, 1], abs=0.01)
    assert left.rotation[:, 2] == pytest.approx(right.rotation[:, 2] * [1, -1, 1], abs=0.05)

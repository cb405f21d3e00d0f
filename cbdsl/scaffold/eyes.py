"""A pair of fixed cameras for a robot that has none: they look at its bench from beyond."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.bench import Bench, bench
from cbdsl.robot.link_place import PLACING
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.robot_xml import robot_text
from cbdsl.robot.semantic_groups import SemanticGroup
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.scaffold.model_source import localized, with_origin
from cbdsl.scaffold.proposed_effector import values_lines
from cbdsl.scaffold.tip_link import hand_corners, working_frame
from cbdsl.storage.atomic_file import write_text
from cbdsl.yaml_text.library import Library

# Places of the cameras in parts of the reach: beyond the bench's centre, to either side, above.
_BEYOND, _APART, _ABOVE = 0.7, 0.2, 0.7
Pose = tuple[str, str]
"""Position, and roll, pitch and yaw, as URDF writes them."""

# Line of a proposed document that the cameras replace.
_HINT = (
    "# Add load_cells, cameras and vision for perception; cb schema robot describes their keys.\n"
)
_CAMERAS = """\
# They stand for those of the robot's cell, with which programs see: measure where those are.
cameras:
  left: {link: left_camera, width: 320, height: 240, focal_length: 418.5 px}
  right: {link: right_camera, width: 320, height: 240, focal_length: 418.5 px}
"""


def add_eyes(file: Path) -> Path:
    """Give a proposed robot two cameras, in a copy of its model beside its document.

    Args:
        file: Document of the robot, as it was proposed.

    Returns:
        Model with the cameras.

    Raises:
        UsageError: The model has links of their names.
    """
    robot = Library().read(file, RobotDocument).document
    model, target = file.parent / robot.model, file.with_suffix(".urdf")
    if target.exists() and target.resolve() != model.resolve():
        raise UsageError(f"{target} is there; --force does not replace the model of another robot")
    packages = PackageFolders({}, [], model)
    root = ElementTree.fromstring(
        localized(robot_text(model), model, file.parent, packages, robot.name)
    )
    if {"left_camera", "right_camera"} & {link.get("name") for link in root.findall("link")}:
        raise UsageError(f"{model} has cameras: write them in 'cameras' of {file}")
    before = bench(robot, file)
    for side, name in ((-1.0, "left_camera"), (1.0, "right_camera")):
        _add(root, name, robot.base, _pose(before, side))
    tips = dict(_tips(robot, read_urdf(model)))
    for name, (link, frame) in tips.items():
        _add(root, f"{name}_tip", link, frame)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    write_text(with_origin(text, f"From {robot.model}, with cameras."), target)
    lines = file.read_text("utf-8").splitlines(keepends=True)
    written = [f"model: {target.name}\n" if line.startswith("model: ") else line for line in lines]
    document = "".join(written).replace(_HINT, _CAMERAS)
    for name in tips:
        document = _with_tip(document, name, robot, read_urdf(target))
    write_text(document, file)
    return target


def _tips(robot: RobotDocument, model: UrdfModel) -> Iterator[tuple[str, tuple[str, Pose]]]:
    """Yield the arms whose tip is not where their hand works, with its link and that frame."""
    for name, arm in robot.effectors.items():
        if arm.tip is not None and len(arm.joints) >= PLACING:
            points = hand_corners(model, model.joints[arm.joints[-1]].child, arm.tip.link)
            frame = working_frame(points, arm.tip.offset)
            if frame is not None:
                place, turn = (" ".join(f"{each:.9g}" for each in frame[i : i + 3]) for i in (0, 3))
                yield name, (arm.tip.link, (place, turn))


def _with_tip(document: str, name: str, robot: RobotDocument, model: UrdfModel) -> str:
    """Return a proposed document with the added link as the tip of an effector."""
    link, joints = f"{name}_tip", [model.joints[each] for each in robot.effectors[name].joints]
    arm = SemanticGroup(tuple(joints), link, {})
    values = values_lines(model, arm, (0.0, 0.0, 0.0), None)[-1].strip()
    before, head, rest = document.partition(f"\n  {name}:\n")
    rest = re.sub(r"(?m)^    tip: .*$", f"    tip: {{link: {link}}}", rest, count=1)
    return before + head + re.sub(r"(?m)^    values: .*$", f"    {values}", rest, count=1)


def _pose(before: Bench, side: float) -> Pose:
    """Return a camera's position and its roll, pitch and yaw, as URDF writes them."""
    x, y, z = before.position
    away = math.hypot(x, y)
    ahead = (x / away, y / away) if away > _APART * before.reach else (1.0, 0.0)
    beyond, apart, above = (part * before.reach for part in (_BEYOND, side * _APART, _ABOVE))
    east = beyond * ahead[0] - apart * ahead[1]
    north = beyond * ahead[1] + apart * ahead[0]
    pitch, yaw = math.atan2(above, math.hypot(beyond, apart)), math.atan2(-north, -east)
    return f"{x + east:.4f} {y + north:.4f} {z + above:.4f}", f"0 {pitch:.6f} {yaw:.6f}"


def _add(root: ElementTree.Element, name: str, base: str, pose: Pose) -> None:
    """Add a link without shape on a fixed joint."""
    inertial = ElementTree.SubElement(ElementTree.SubElement(root, "link", name=name), "inertial")
    ElementTree.SubElement(inertial, "mass", value="0")
    moments = dict.fromkeys(("ixx", "iyy", "izz"), "1e-06")
    ElementTree.SubElement(inertial, "inertia", {**moments, "ixy": "0", "ixz": "0", "iyz": "0"})
    joint = ElementTree.SubElement(root, "joint", name=f"{name}_joint", type="fixed")
    ElementTree.SubElement(joint, "parent", link=base)
    ElementTree.SubElement(joint, "child", link=name)
    ElementTree.SubElement(joint, "origin", xyz=pose[0], rpy=pose[1])

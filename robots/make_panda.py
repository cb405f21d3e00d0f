"""Writes robots/panda.urdf: a Franka Emika Panda out of boxes, cylinders and spheres.

Run ``python robots/make_panda.py`` after a change here. Lengths are in m, angles in rad, masses in
kg. Frames, limits and efforts are the manufacturer's published ones (the Denavit-Hartenberg
parameters and joint limits of its interface documentation); shapes and masses are rough. The world
frame is that of the base, which stands on the table. Two cameras look at the table from the other
side. All materials are grey, so that nothing of the robot is a saturated colour to its cameras.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

Triple = tuple[float, float, float]
ORIGIN: Triple = (0.0, 0.0, 0.0)
QUARTER = math.pi / 2

# Origin and turn in the frame before, limits, speed, torque and mass of the link.
ARM: Sequence[tuple[Triple, float, float, float, float, float, float]] = (
    ((0.0, 0.0, 0.333), 0.0, -2.8973, 2.8973, 2.175, 87.0, 3.0),
    ((0.0, 0.0, 0.0), -QUARTER, -1.7628, 1.7628, 2.175, 87.0, 3.0),
    ((0.0, -0.316, 0.0), QUARTER, -2.8973, 2.8973, 2.175, 87.0, 2.5),
    ((0.0825, 0.0, 0.0), QUARTER, -3.0718, -0.0698, 2.175, 87.0, 2.5),
    ((-0.0825, 0.384, 0.0), -QUARTER, -2.8973, 2.8973, 2.61, 12.0, 2.0),
    ((0.0, 0.0, 0.0), QUARTER, -0.0175, 3.7525, 2.61, 12.0, 1.5),
    ((0.088, 0.0, 0.0), QUARTER, -2.8973, 2.8973, 2.61, 12.0, 0.5),
)
# Where the limbs between joints are, as capsules' ends and radii, by the number of the link.
LIMBS: dict[int, Sequence[tuple[Triple, Triple, float]]] = {
    0: (((0.0, 0.0, 0.0), (0.0, 0.0, 0.14), 0.07),),
    1: (((0.0, 0.0, -0.19), (0.0, 0.0, -0.06), 0.06),),
    2: (((0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.06),),
    3: (((0.0, 0.0, -0.22), (0.0, 0.0, -0.06), 0.055), ((0.0, 0.0, -0.06), (0.06, 0.0, 0.0), 0.05)),
    4: (((0.0, 0.0, -0.05), (0.0, 0.0, 0.05), 0.05), ((0.0, 0.0, 0.0), (-0.0825, 0.12, 0.0), 0.05)),
    5: (((0.0, 0.02, -0.26), (0.0, 0.06, -0.04), 0.045),),
    6: (((0.0, 0.0, -0.02), (0.0, 0.0, 0.04), 0.045),),
    7: (((0.0, 0.0, 0.0), (0.0, 0.0, 0.08), 0.045),),
}
FLANGE = 0.107
FINGER_STROKE, FINGER_SPEED, FINGER_FORCE = 0.04, 0.2, 70.0
KNUCKLE = 0.0584
# The pad of a finger, whose inner side is in the finger's own plane y = 0.
PAD: Triple = (0.018, 0.008, 0.018)
PAD_AT = 0.045
# The cameras' place, which they both look away from towards the middle of the table.
MAST, HALF_BASELINE, LOOKED_AT = (1.25, 0.0, 0.75), 0.2, (0.5, 0.0, 0.0)


def main() -> None:
    robot = ET.Element("robot", name="panda")
    link(robot, "panda_link0", 3.0, LIMBS[0])
    for number, (xyz, turn, lower, upper, speed, torque, mass) in enumerate(ARM, 1):
        link(robot, f"panda_link{number}", mass, LIMBS[number])
        moving = joint(robot, f"panda_joint{number}", "revolute", number - 1, number)
        ET.SubElement(moving, "origin", xyz=text(xyz), rpy=text((turn, 0.0, 0.0)))
        ET.SubElement(moving, "axis", xyz="0 0 1")
        limit(moving, lower, upper, speed, torque)
    hand(robot)
    for side, y in (("left", -HALF_BASELINE), ("right", HALF_BASELINE)):
        camera(robot, f"{side}_camera", (MAST[0], y, MAST[2]))
    ET.indent(robot)
    file = Path(__file__).with_name("panda.urdf")
    file.write_text(f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n')


def hand(robot: ET.Element) -> None:
    """Add the gripper: two fingers that slide apart along y."""
    body = element(robot, "panda_hand", 0.7)
    box(body, (0.05, 0.2, 0.05), (0.0, 0.0, 0.03))
    mount = joint(robot, "panda_hand_joint", "fixed", 7, "panda_hand")
    ET.SubElement(mount, "origin", xyz=f"0 0 {FLANGE}", rpy=text((0.0, 0.0, -math.pi / 4)))
    for number, side, outward in ((1, "left", 1.0), (2, "right", -1.0)):
        finger = element(robot, f"panda_{side}finger", 0.05)
        box(finger, (0.02, 0.012, 0.036), (0.0, outward * 0.012, 0.018))
        slide = joint(
            robot, f"panda_finger_joint{number}", "prismatic", "panda_hand", f"panda_{side}finger"
        )
        ET.SubElement(slide, "origin", xyz=f"0 0 {KNUCKLE}")
        ET.SubElement(slide, "axis", xyz=text((0.0, outward, 0.0)))
        limit(slide, 0.0, FINGER_STROKE, FINGER_SPEED, FINGER_FORCE)
        pad = element(robot, f"panda_{side}finger_pad", 0.01)
        box(pad, PAD, (0.0, outward * PAD[1] / 2, 0.0))
        held = joint(
            robot, f"panda_{side}finger_pad_joint", "fixed",
            f"panda_{side}finger", f"panda_{side}finger_pad",
        )  # fmt: skip
        ET.SubElement(held, "origin", xyz=f"0 0 {PAD_AT}")


def camera(robot: ET.Element, name: str, place: Triple) -> None:
    """Add a camera that looks from a place at the middle of the table."""
    x, y, z = (there - here for there, here in zip(LOOKED_AT, place, strict=True))
    turn = (0.0, math.atan2(-z, math.hypot(x, y)), math.atan2(y, x))
    element(robot, name, 0.0)
    mount = joint(robot, f"{name}_joint", "fixed", 0, name)
    ET.SubElement(mount, "origin", xyz=text(place), rpy=text(turn))


def link(
    robot: ET.Element, name: str, mass: float, limbs: Sequence[tuple[Triple, Triple, float]]
) -> None:
    """Add a link with limbs that are cylinders with round ends."""
    body = element(robot, name, mass)
    for start, end, radius in limbs:
        way = [b - a for a, b in zip(start, end, strict=True)]
        middle = tuple((a + b) / 2 for a, b in zip(start, end, strict=True))
        length = math.hypot(*way)
        turn = (math.atan2(-way[1], way[2]), math.asin(way[0] / length), 0.0)
        shape(body, "cylinder", middle, turn, radius=f"{radius:g}", length=f"{length:.4g}")
        for place in (start, end):
            shape(body, "sphere", place, ORIGIN, radius=f"{radius:g}")


def element(robot: ET.Element, name: str, mass: float) -> ET.Element:
    """Add a link with the inertia of a ball of its mass and 5 cm radius."""
    body = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(body, "inertial")
    ET.SubElement(inertial, "mass", value=f"{mass:g}")
    moment = f"{max(0.4 * mass * 0.05**2, 1e-6):.3g}"
    ET.SubElement(
        inertial, "inertia", ixx=moment, iyy=moment, izz=moment, ixy="0", ixz="0", iyz="0"
    )
    return body


def box(body: ET.Element, size: Triple, place: Triple) -> None:
    shape(body, "box", place, ORIGIN, size=text(size))


def shape(body: ET.Element, kind: str, place: Sequence[float], turn: Triple, **size: str) -> None:
    """Add a shape for both visual and collision."""
    for use in ("visual", "collision"):
        part = ET.SubElement(body, use)
        ET.SubElement(part, "origin", xyz=text(place), rpy=text(turn))
        ET.SubElement(ET.SubElement(part, "geometry"), kind, size)
        if use == "visual":
            material = ET.SubElement(part, "material", name="grey")
            ET.SubElement(material, "color", rgba="0.6 0.6 0.6 1")


def joint(
    robot: ET.Element, name: str, kind: str, parent: int | str, child: int | str
) -> ET.Element:
    """Add a joint between two links; numbers name the links of the arm."""
    moving = ET.SubElement(robot, "joint", name=name, type=kind)
    for end, given in (("parent", parent), ("child", child)):
        ET.SubElement(moving, end, link=given if isinstance(given, str) else f"panda_link{given}")
    return moving


def limit(moving: ET.Element, lower: float, upper: float, speed: float, effort: float) -> None:
    numbers = {"lower": lower, "upper": upper, "velocity": speed, "effort": effort}
    ET.SubElement(moving, "limit", {key: f"{value:g}" for key, value in numbers.items()})


def text(numbers: Sequence[float]) -> str:
    return " ".join(f"{number:.9g}" for number in numbers)


if __name__ == "__main__":
    main()

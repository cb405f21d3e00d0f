"""Writes robots/dexter.urdf: Dexter's body out of boxes, cylinders and spheres.

Run ``python robots/make_dexter.py`` after a change here. Lengths are in m, angles in rad, masses in
kg. The world frame is the torso's: x forward, y to the robot's left, z up. All materials are grey,
so that nothing of the robot's own body is a saturated colour to its cameras.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path

Triple = tuple[float, float, float]
ORIGIN: Triple = (0.0, 0.0, 0.0)

LIGHT, DARK, RUBBER = 0.55, 0.2, 0.1
SIDES = {"left": 1.0, "right": -1.0}

#: Where joint 1 of the left arm hangs, turned so that its axis points straight down.
SHOULDER: Triple = (0.07, 0.17, 0.21)
HANGING: Triple = (0.0, pi, 0.0)
NECK: Triple = (0.24, 0.0, 0.50)
HALF_BASELINE = 0.15
VERGENCE = 0.15

PALM_AHEAD_OF_JOINT_7 = 0.06 + 0.076
KNUCKLE_OFFSET = 0.025
KNUCKLE, PROXIMAL, DISTAL = 0.05, 0.07, 0.058
TIP_RADIUS = 0.012
KNUCKLE_PITCH, DISTAL_BEND = radians(2.46), radians(45.0)
FLEXION = (0.0, 2.44)


@dataclass(frozen=True)
class Solid:
    """A primitive: ``kind`` and the attributes of its URDF element, centred at ``at``."""

    kind: str
    size: Sequence[float]
    grey: float
    at: Triple = ORIGIN

    def attributes(self) -> dict[str, str]:
        """As URDF writes them."""
        if self.kind == "box":
            return {"size": text(self.size)}
        return dict(zip(("radius", "length"), map(number, self.size), strict=False))

    def inertia(self, mass: float) -> Triple:
        """Principal moments of the solid with this mass, kg m^2."""
        if self.kind == "sphere":
            moment = 0.4 * mass * self.size[0] ** 2
            return moment, moment, moment
        if self.kind == "box":
            x, y, z = self.size
            return (
                mass / 12 * (y * y + z * z),
                mass / 12 * (x * x + z * z),
                mass / 12 * (x * x + y * y),
            )
        radius, length = self.size
        across = mass / 12 * (3 * radius * radius + length * length)
        return across, across, mass * radius * radius / 2


@dataclass(frozen=True)
class Drive:
    """Axis, limits and strength of a revolute joint, and the joint that a passive one follows."""

    limits: tuple[float, float]
    effort: float
    speed: float
    axis: Triple = (0.0, 0.0, 1.0)
    follows: str | None = None
    ratio: float = 1.0


@dataclass(frozen=True)
class ArmSegment:
    """One joint of the arm with the link that it turns.

    ``step`` and ``twist`` lead to the next joint's frame: a translation, then a turn about x
    (Denavit and Hartenberg's a and d, and alpha).
    """

    step: Triple
    twist: float
    drive: Drive
    mass: float
    solid: Solid


ARM = (
    ArmSegment(
        ORIGIN,
        -pi / 2,
        Drive((-2.6, 2.6), 78, 2.5),
        4.0,
        Solid("cylinder", (0.07, 0.16), LIGHT, (0, 0, -0.06)),
    ),
    ArmSegment(
        ORIGIN,
        pi / 2,
        Drive((-2.0, 2.0), 107, 2.5),
        3.9,
        Solid("cylinder", (0.06, 0.14), LIGHT),
    ),
    ArmSegment(
        (0.045, 0, 0.55),
        -pi / 2,
        Drive((-2.8, 2.8), 57, 2.5),
        1.8,
        Solid("cylinder", (0.05, 0.44), LIGHT, (0, 0, 0.29)),
    ),
    ArmSegment(
        (-0.045, 0, 0),
        pi / 2,
        Drive((-0.9, 3.1), 60, 2.5),
        2.4,
        Solid("cylinder", (0.045, 0.11), LIGHT),
    ),
    ArmSegment(
        (0, 0, 0.3),
        -pi / 2,
        Drive((-4.76, 1.24), 20, 5),
        0.35,
        Solid("cylinder", (0.04, 0.22), LIGHT, (0, 0, 0.12)),
    ),
    ArmSegment(
        ORIGIN,
        pi / 2,
        Drive((-1.6, 1.6), 20, 5),
        0.41,
        Solid("cylinder", (0.035, 0.08), LIGHT),
    ),
    ArmSegment(
        ORIGIN,
        0.0,
        Drive((-3.0, 3.0), 6, 5),
        0.2,
        Solid("cylinder", (0.04, 0.02), DARK, (0, 0, 0.05)),
    ),
)


def number(value: float) -> str:
    """Return a number with nine significant digits as text."""
    return f"{value:.9g}"


def text(values: Sequence[float]) -> str:
    """Return numbers separated by spaces."""
    return " ".join(map(number, values))


class Body:
    """A URDF document under construction."""

    def __init__(self, name: str) -> None:
        self.root = ET.Element("robot", name=name)

    def link(self, name: str, mass: float, solids: Sequence[Solid], least_inertia: float) -> None:
        """Add a link with the mass of its first solid.

        ``least_inertia`` bounds the moments from below, because solvers become unstable if light
        links carry heavy ones.
        """
        link = ET.SubElement(self.root, "link", name=name)
        core = solids[0] if solids else Solid("sphere", (0.02,), DARK)
        self._inertial(link, mass, core, least_inertia)
        for index, solid in enumerate(solids):
            for role in ("visual", "collision"):
                part = ET.SubElement(link, role)
                ET.SubElement(part, "origin", xyz=text(solid.at), rpy=text(ORIGIN))
                shape = ET.SubElement(part, "geometry")
                ET.SubElement(shape, solid.kind, solid.attributes())
                if role == "visual":
                    material = ET.SubElement(part, "material", name=f"{name}_{index}")
                    ET.SubElement(material, "color", rgba=text((*[solid.grey] * 3, 1)))

    @staticmethod
    def _inertial(link: ET.Element, mass: float, core: Solid, least_inertia: float) -> None:
        moments = [max(moment, least_inertia) for moment in core.inertia(mass)]
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "origin", xyz=text(core.at), rpy=text(ORIGIN))
        ET.SubElement(inertial, "mass", value=number(mass))
        diagonal = dict(zip(("ixx", "iyy", "izz"), map(number, moments), strict=True))
        ET.SubElement(inertial, "inertia", {**diagonal, "ixy": "0", "ixz": "0", "iyz": "0"})

    def joint(
        self,
        name: str,
        parent: str,
        child: str,
        at: Triple,
        turned: Triple = ORIGIN,
        drive: Drive | None = None,
    ) -> None:
        """Add a joint at ``at``, ``turned`` by roll, pitch and yaw; fixed without a drive."""
        joint = ET.SubElement(self.root, "joint", name=name, type="revolute" if drive else "fixed")
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=child)
        ET.SubElement(joint, "origin", xyz=text(at), rpy=text(turned))
        if drive is None:
            return
        ET.SubElement(joint, "axis", xyz=text(drive.axis))
        ET.SubElement(
            joint,
            "limit",
            lower=number(drive.limits[0]),
            upper=number(drive.limits[1]),
            effort=number(drive.effort),
            velocity=number(drive.speed),
        )
        ET.SubElement(joint, "dynamics", damping="0", friction="0")
        if drive.follows:
            ET.SubElement(
                joint,
                "mimic",
                joint=drive.follows,
                multiplier=number(drive.ratio),
                offset="0",
            )

    def __str__(self) -> str:
        ET.indent(self.root)
        return '<?xml version="1.0"?>\n' + ET.tostring(self.root, encoding="unicode") + "\n"


def add_arm(body: Body, side: str, shoulder: Triple, axes: Triple) -> None:
    """Add an arm: seven joints from the torso to the palm.

    Args:
        body: Body of the robot.
        side: Side of the arm, left or right; the right arm is the mirror image of the left one.
        shoulder: Position of the left arm's joint 1, m.
        axes: Roll, pitch and yaw of that joint, rad.
    """
    sign, (roll, pitch, yaw) = SIDES[side], axes
    parent, at = "torso", (shoulder[0], sign * shoulder[1], shoulder[2])
    turned = sign * roll + 0.0, pitch, sign * yaw + 0.0  # no -0 in the file
    for index, segment in enumerate(ARM, 1):
        link = f"{side}_link_{index}"
        body.link(link, segment.mass, (segment.solid,), least_inertia=1e-3)
        body.joint(f"{side}_arm_{index}", parent, link, at, turned, segment.drive)
        parent, at, turned = link, segment.step, (segment.twist, 0.0, 0.0)
    solids = (
        Solid("cylinder", (0.045, 0.060), DARK, (0, 0, -0.046)),
        Solid("box", (0.10, 0.10, 0.02), DARK, (0, 0, -0.012)),
    )
    body.link(f"{side}_palm", 1.0, solids, least_inertia=1e-3)
    body.joint(f"{side}_wrist", parent, f"{side}_palm", (0.0, 0.0, PALM_AHEAD_OF_JOINT_7))


def add_knuckles(body: Body, side: str) -> None:
    """Add the bases of the fingers: 1 and 2 spread around the palm, 3 is the fixed thumb."""
    solid = Solid("box", (0.05, 0.022, 0.018), LIGHT, (0.025, 0, -0.002))
    for finger, outward in ((1, -1.0), (2, 1.0), (3, 0.0)):
        link = f"{side}_finger_{finger}_knuckle"
        at, yaw = (KNUCKLE_OFFSET * outward, 0.0, 0.0), -pi / 2 if outward else pi / 2
        body.link(link, 0.06, (solid,), least_inertia=5e-5)
        name, drive = f"{link}_mount", None
        if outward:
            name = f"{side}_spread" if finger == 1 else f"{side}_spread_2"
            follows = f"{side}_spread" if finger == 2 else None
            drive = Drive((0.0, pi), 5, 4, axis=(0.0, 0.0, outward), follows=follows)
        body.joint(name, f"{side}_palm", link, at, (0.0, 0.0, yaw), drive)


def add_finger(body: Body, side: str, finger: int) -> None:
    """Add the two phalanges of a finger and the fingertip with its load cell."""
    name = f"{side}_finger_{finger}"
    proximal = Solid("box", (0.066, 0.018, 0.020), LIGHT, (0.035, 0, 0))
    body.link(f"{name}_proximal", 0.06, (proximal,), least_inertia=5e-5)
    body.joint(
        name,
        f"{name}_knuckle",
        f"{name}_proximal",
        (KNUCKLE, 0.0, 0.0),
        (pi / 2, -KNUCKLE_PITCH, 0.0),
        Drive(FLEXION, 5, 4),
    )
    distal = Solid("box", (0.040, 0.016, 0.018), LIGHT, (0.022, 0, 0))
    body.link(f"{name}_distal", 0.04, (distal,), least_inertia=3e-5)
    body.joint(
        f"{name}_distal",
        f"{name}_proximal",
        f"{name}_distal",
        (PROXIMAL, 0.0, 0.0),
        (0.0, 0.0, DISTAL_BEND),
        Drive((0.0, 0.84), 5, 4, follows=name, ratio=1 / 3),
    )
    body.link(f"{name}_tip", 0.02, (Solid("sphere", (TIP_RADIUS,), RUBBER),), least_inertia=1e-5)
    body.joint(f"{name}_cell", f"{name}_distal", f"{name}_tip", (DISTAL - TIP_RADIUS, 0.0, 0.0))


def add_head(body: Body) -> None:
    """Add pan, tilt, and two cameras that converge in front of the head."""
    pan = Solid("cylinder", (0.04, 0.06), DARK, (0, 0, -0.03))
    body.link("head_pan", 1.0, (pan,), least_inertia=1e-3)
    body.joint("pan", "torso", "head_pan", NECK, drive=Drive((-1.7, 1.7), 30, 4))
    tilt = Solid("box", (0.06, 2 * HALF_BASELINE + 0.08, 0.05), DARK, (0, 0, 0.03))
    body.link("head_tilt", 1.5, (tilt,), least_inertia=1e-3)
    drive = Drive((-1.0, 1.5), 30, 4, axis=(0.0, 1.0, 0.0))
    body.joint("tilt", "head_pan", "head_tilt", (0.0, 0.0, 0.03), drive=drive)
    for side, sign in SIDES.items():
        at = (0.04, sign * HALF_BASELINE, 0.03)
        body.link(f"{side}_camera", 0.05, (), least_inertia=1e-5)
        body.joint(
            f"{side}_camera_mount", "head_tilt", f"{side}_camera", at, (0.0, 0.0, -sign * VERGENCE)
        )


def dexter(shoulder: Triple = SHOULDER, axes: Triple = HANGING) -> str:
    """Return the text of robots/dexter.urdf, or of a Dexter with other mounts; see ``add_arm``."""
    body = Body("dexter")
    torso = Solid("box", (0.10, 0.20, 0.5), DARK, (-0.12, 0, -0.1))
    body.link("torso", 40.0, (torso,), least_inertia=1e-2)
    for side in SIDES:
        add_arm(body, side, shoulder, axes)
        add_knuckles(body, side)
        for finger in (1, 2, 3):
            add_finger(body, side, finger)
    add_head(body)
    return str(body)


if __name__ == "__main__":
    Path(__file__).with_name("dexter.urdf").write_text(dexter(), encoding="utf-8")

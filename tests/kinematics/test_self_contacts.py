"""Self-contacts of a model: which of its links touch in a posture, and which in all."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cbdsl.kinematics.self_contacts import SelfContacts
from cbdsl.robot.urdf_reader import read_urdf

LINK = """
  <link name="{name}">
    <inertial>
      <mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><origin xyz="{at}"/><geometry>{shape}</geometry></collision>
  </link>"""
JOINT = """
  <joint name="{name}" type="revolute">
    <parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{at}"/><axis xyz="{axis}"/>
    <limit lower="{lower}" upper="{upper}" effort="20" velocity="2"/>
  </joint>"""
BRACKET = """
  <joint name="{name}" type="fixed">
    <parent link="{parent}"/><child link="{child}"/><origin xyz="{at}"/>
  </joint>"""


def box(x: float, y: float, z: float) -> str:
    return f'<box size="{x} {y} {z}"/>'


def two_arms(lower: float = -1.5, upper: float = 1.5) -> str:
    """Return a column with two short arms, which lie along x, 10 cm apart, and turn about z.

    A cuff on the column is so near the left shoulder that it overlaps that arm in every posture,
    and pushes it aside.
    """
    parts = [
        LINK.format(name="column", at="0 0 0", shape=box(0.1, 0.1, 0.4)),
        LINK.format(name="cuff", at="0 0 0", shape='<cylinder radius="0.08" length="0.1"/>'),
        LINK.format(name="left", at="0.15 0 0", shape=box(0.3, 0.04, 0.04)),
        LINK.format(name="right", at="0.15 0 0", shape=box(0.3, 0.04, 0.04)),
        BRACKET.format(name="weld", parent="column", child="cuff", at="0.16 0.09 0.3"),
    ]
    for name, y in (("left", 0.05), ("right", -0.05)):
        parts.append(
            JOINT.format(
                name=f"{name}_joint",
                parent="column",
                child=name,
                at=f"0.08 {y} 0.3",
                axis="0 0 1",
                lower=lower,
                upper=upper,
            )
        )
    return f'<robot name="two_arms">{"".join(parts)}\n</robot>'


@pytest.fixture
def contacts(tmp_path: Path) -> SelfContacts:
    (tmp_path / "two_arms.urdf").write_text(two_arms())
    return SelfContacts(read_urdf(tmp_path / "two_arms.urdf"))


def test_links_that_carry_each_other_are_no_pair(contacts: SelfContacts) -> None:
    # Both arms reach into the column's corner, which is their parent.
    assert not any("column" in pair for pair in contacts.touching({}))


def test_touching_links_depend_on_the_posture(contacts: SelfContacts) -> None:
    apart = contacts.touching({"left_joint": 0.5, "right_joint": -0.5})
    crossed = contacts.touching({"left_joint": -0.5, "right_joint": 0.5})
    assert (
        apart == {("cuff", "left"), ("cuff", "right")} - {("cuff", "right")}
        or (
            "left",
            "right",
        )
        not in apart
    )
    assert ("left", "right") in crossed


def test_touching_is_a_matter_of_geometry(contacts: SelfContacts) -> None:
    """Compare inner edges 6 cm apart: they meet where the tips come to the middle."""
    half = math.asin(0.03 / 0.3)  # of the outer inner edge, about, at 30 cm
    assert ("left", "right") not in contacts.touching(
        {"left_joint": -half * 0.8, "right_joint": half * 0.8}
    )
    assert ("left", "right") in contacts.touching(
        {"left_joint": -half * 1.3, "right_joint": half * 1.3}
    )


def test_links_in_constant_contact_touch_in_every_posture(contacts: SelfContacts) -> None:
    always = contacts.always()
    assert ("cuff", "left") in always and ("left", "right") not in always


def test_shapes_without_volume_and_meshes_that_are_not_there_touch_nothing(tmp_path: Path) -> None:
    flat = two_arms().replace(box(0.3, 0.04, 0.04), '<mesh filename="gone.stl"/>')
    (tmp_path / "flat.urdf").write_text(flat.replace('radius="0.08"', 'radius="0"'))
    assert SelfContacts(read_urdf(tmp_path / "flat.urdf")).always() == frozenset()

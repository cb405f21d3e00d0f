"""Who holds a thing, and where it goes with them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.kinematic.grasp import STIFFNESS, Grasp
from cbdsl.backends.kinematic.hands import Fingertip, FingertipContact
from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.stage import Surface
from cbdsl.kinematics.pose import Pose

RADIUS, MASS, FRICTION = 0.05, 0.3, 0.8
UP = np.array([0.0, 0.0, 1.0])


class Carriers:
    """Hands that are where a test puts them."""

    def __init__(self) -> None:
        self.poses = {"left": Pose(np.zeros(3), np.eye(3)), "right": Pose(np.zeros(3), np.eye(3))}

    def cross_axis(self, hands: Sequence[str]) -> int:
        return 0

    def carrier_pose(self, hands: Sequence[str], axis: int) -> Pose:
        return self.poses[hands[0]]


@pytest.fixture
def carriers() -> Carriers:
    return Carriers()


@pytest.fixture
def thing() -> KinematicObject:
    surface = Surface(friction=FRICTION)
    pose = Pose(np.zeros(3), np.eye(3))
    return KinematicObject(SceneObject("ball", SolidShape.ball(RADIUS), surface, MASS, pose))


@pytest.fixture
def grasp(thing: KinematicObject, carriers: Carriers) -> Grasp:
    hands: Any = carriers
    return Grasp(thing, hands)


def touch(thing: KinematicObject, hand: str, angle: float, force: float = 3.0) -> FingertipContact:
    """Return the contact of a fingertip that presses on the ball's equator, at an angle about z."""
    x, y = math.cos(angle), math.sin(angle)
    tip = Fingertip(0, "tip", np.zeros(3), 0.012, 1.0, np.zeros(0, np.intp))
    point, normal = (RADIUS * x, RADIUS * y, 0.0), (-x, -y, 0.0)
    return FingertipContact(hand, tip, thing, force / STIFFNESS, point, normal)


def test_opposed_fingers_hold_an_object(grasp: Grasp, thing: KinematicObject) -> None:
    grasp.update([touch(thing, "right", 0.0), touch(thing, "right", math.pi)])
    assert grasp.holders == ("right",)
    grasp.update([touch(thing, "right", 0.0)])
    assert grasp.holders == ()
    grasp.update([])
    assert grasp.holders == ()


@pytest.mark.parametrize(("share", "holds"), [(0.95, True), (1.05, False)])
def test_grasp_requires_contacts_within_the_friction_cones(
    grasp: Grasp, thing: KinematicObject, share: float, holds: bool
) -> None:
    """On a ball the way makes the same angle with both normals."""
    slant = 2 * share * math.atan(FRICTION)
    grasp.update([touch(thing, "right", 0.0), touch(thing, "right", math.pi - slant)])
    assert bool(grasp.holders) == holds


@pytest.mark.parametrize(("share", "holds"), [(0.95, False), (1.05, True)])
def test_friction_has_to_bear_the_weight(
    grasp: Grasp, thing: KinematicObject, share: float, holds: bool
) -> None:
    force = share * MASS * GRAVITY / FRICTION / 2
    grasp.update([touch(thing, "right", 0.0, force), touch(thing, "right", math.pi, force)])
    assert bool(grasp.holders) == holds


def test_two_hands_hold_an_object_together(grasp: Grasp, thing: KinematicObject) -> None:
    grasp.update([touch(thing, "left", 0.0), touch(thing, "right", math.pi)])
    assert grasp.holders == ("left", "right")


def test_first_holder_keeps_an_object_until_its_grasp_fails(
    grasp: Grasp, thing: KinematicObject
) -> None:
    """Hands that take it have it once the other hand lets go."""
    right = [touch(thing, "right", 0.0), touch(thing, "right", math.pi)]
    left = [touch(thing, "left", 0.5), touch(thing, "left", 0.5 + math.pi)]
    grasp.update(right)
    grasp.update(left + right)
    assert grasp.holders == ("right",)
    grasp.update(left)
    assert grasp.holders == ("left",)
    grasp.update(left + right)
    assert grasp.holders == ("left",)


def test_thing_goes_along_with_its_carrier(
    grasp: Grasp, thing: KinematicObject, carriers: Carriers
) -> None:
    carriers.poses["right"] = Pose(np.array([0.1, 0.0, 0.0]), np.eye(3))
    grasp.update([touch(thing, "right", 0.0), touch(thing, "right", math.pi)])
    turned = Pose.turned(UP, math.pi / 2).rotation
    carriers.poses["right"] = Pose(np.array([0.5, 0.2, 0.3]), turned)
    grasp.follow()
    # It was 10 cm behind the hand along x, which is now the world's y.
    assert thing.position == pytest.approx([0.5, 0.1, 0.3])
    assert thing.pose.rotation == pytest.approx(turned)


def test_stick_is_zero_without_a_grasp(grasp: Grasp, thing: KinematicObject) -> None:
    both = [touch(thing, "right", 0.0), touch(thing, "right", math.pi)]
    assert grasp.stick(both) == 0.0
    grasp.update(both)
    assert grasp.stick(both) == pytest.approx(2 * 3.0 * FRICTION)

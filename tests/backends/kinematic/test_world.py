"""Released objects stand, fall, roll and slide according to mechanics."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.kinematic.kinematic_object import KinematicObject
from cbdsl.backends.kinematic.world import World
from cbdsl.backends.staging.scenario import GRAVITY, SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.stage import Surface
from cbdsl.kinematics.pose import Pose

PERIOD = 1 / 60
SHAPES = {
    "ball": SolidShape.ball(0.05),
    "box": SolidShape("box", (0.05, 0.05, 0.05)),
    "cylinder": SolidShape.cylinder(0.05, 0.1),
}


def world_with(
    shape: SolidShape, height: float, rolling_friction: float = 0.0, friction: float = 0.5
) -> tuple[World, KinematicObject]:
    """Return a world with a 2 m wide table, top at 0, and an object ``height`` above it."""
    world = World()
    table = SolidShape("box", (1.0, 1.0, 0.02))
    at = Pose(np.array([0, 0, -0.02]), np.eye(3))
    world.add(SceneObject("table", table, Surface(friction=0.5), 0.0, at))
    pose = Pose(np.array([0, 0, height + shape.half_height]), np.eye(3))
    surface = Surface(friction=friction, rolling_friction=rolling_friction)
    return world, world.add(SceneObject("thing", shape, surface, 0.2, pose))


def let_go(world: World, thing: KinematicObject, seconds: float) -> None:
    for _ in range(round(seconds / PERIOD)):
        world.let_go(thing, PERIOD)


@pytest.mark.parametrize("name", SHAPES)
def test_object_on_a_support_stays(name: str) -> None:
    world, thing = world_with(SHAPES[name], 0.0)
    before = thing.position.copy()
    let_go(world, thing, 1.0)
    assert thing.position == pytest.approx(before)
    assert thing.resting


@pytest.mark.parametrize("name", SHAPES)
def test_released_object_falls_onto_the_table(name: str) -> None:
    world, thing = world_with(SHAPES[name], 0.3)
    let_go(world, thing, 0.2)
    fallen = 0.35 - float(thing.position[2])
    assert fallen == pytest.approx(GRAVITY * 0.2**2 / 2, rel=0.1)
    let_go(world, thing, 1.0)
    assert thing.position == pytest.approx([0, 0, 0.05])
    assert not thing.velocity.any()


def test_thrown_object_follows_a_parabola() -> None:
    world, thing = world_with(SHAPES["ball"], 0.0)
    thing.launch(np.array([2.0, 0.0, 3.0]))
    let_go(world, thing, 0.3)
    assert thing.position[0] == pytest.approx(0.6)
    assert thing.position[2] == pytest.approx(0.05 + 0.9 - GRAVITY * 0.3**2 / 2, abs=0.03)
    let_go(world, thing, 2.0)
    assert thing.position[2] < -1


def test_box_slides_the_distance_that_friction_allows() -> None:
    world, thing = world_with(SHAPES["box"], 0.0)
    thing.launch(np.array([1.0, 0.0, 0.0]))
    let_go(world, thing, 2.0)
    assert thing.position[0] == pytest.approx(1 / (2 * 0.25 * GRAVITY), rel=0.1)


@pytest.mark.parametrize("name", SHAPES)
def test_launch_without_friction_keeps_the_velocity(name: str) -> None:
    world, thing = world_with(SHAPES[name], 0.0, friction=0.0)
    thing.launch(np.array([0.3, 0.0, 0.0]))
    let_go(world, thing, 1.0)
    assert thing.velocity == pytest.approx([0.3, 0, 0])
    assert thing.position[0] == pytest.approx(0.3, rel=0.05)


def test_ball_that_slides_rolls_on_with_five_sevenths_of_its_speed() -> None:
    world, thing = world_with(SHAPES["ball"], 0.0)
    thing.launch(np.array([0.7, 0.0, 0.0]))
    let_go(world, thing, 0.5)
    assert thing.velocity == pytest.approx([0.5, 0, 0])
    assert thing.rolling == pytest.approx([0.5, 0, 0])


def test_rolling_friction_stops_a_ball() -> None:
    world, thing = world_with(SHAPES["ball"], 0.0, rolling_friction=0.002)
    thing.launch(np.array([0.1, 0.0, 0.0]))
    let_go(world, thing, 2.0)
    assert not thing.velocity.any()
    assert 0.0 < thing.position[0] < 0.1


def test_removed_object_is_not_in_the_world() -> None:
    world, thing = world_with(SHAPES["box"], 0.0)
    world.remove("thing")
    assert list(world.things) == ["table"]
    assert world.solids.shape == (1, 16)
    assert world.things["table"].position == pytest.approx([0, 0, -0.02])
    assert thing.position[2] == pytest.approx(0.05)

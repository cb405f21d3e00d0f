"""MuJoCo's own features: worlds that are recompiled in mid-run, rest, and exact repeats."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.stage import Fixture, Surface
from cbdsl.kinematics.pose import Pose
from cbdsl_mujoco.backend import MujocoBackend
from tests.backends.conftest import made_stage

TOP = -0.42
TABLE = {"form": {"shape": "box", "size": [0.6, 1.2, 0.04]}, "position": [0.6, 0, TOP - 0.02]}


def thing(name: str, shape: SolidShape, x: float, y: float, above: float = 0.0) -> SceneObject:
    surface = Surface()
    place = Pose(np.array([x, y, TOP + shape.half_height + above]), np.eye(3))
    return SceneObject(name, shape, surface, 0.3, place)


BOX = SolidShape("box", (0.04, 0.04, 0.04))


def test_adding_and_removing_an_object_changes_no_other_state(blind: MujocoBackend) -> None:
    stage = made_stage({}, fixtures={"table": TABLE})
    blind.reset(stage, None, np.random.default_rng(0))
    engine = blind.truth
    engine.add(thing("falling", BOX, 0.5, 0.0, above=0.4))
    engine.add(thing("standing", BOX, 0.5, 0.2))
    engine.attach("standing")
    for _ in range(6):
        blind.step()
    speed, place = engine.velocity("falling"), engine.pose("falling").position
    robot = engine.read()[0]
    assert speed[2] < -0.5
    engine.add(thing("late", SolidShape.ball(0.05), 0.5, -0.3))
    engine.remove("standing")
    assert engine.names() == ("table", "falling", "late")
    assert engine.velocity("falling") == pytest.approx(speed, abs=0)
    assert engine.pose("falling").position == pytest.approx(place, abs=0)
    assert engine.read()[0] == pytest.approx(robot, abs=0)
    assert len(engine.solids) == 3
    for _ in range(60):
        blind.step()
    assert engine.pose("falling").position[2] == pytest.approx(TOP + 0.04, abs=1e-3)


def test_held_object_stays_when_another_is_added(blind: MujocoBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    engine = blind.truth
    engine.add(thing("held", BOX, 0.5, 0.0, above=0.4))
    engine.attach("held")
    before = engine.pose("held").position
    engine.add(thing("late", BOX, 0.5, 0.4))
    for _ in range(60):
        blind.step()
    assert engine.pose("held").position == pytest.approx(before, abs=1e-4)
    engine.release("held")
    for _ in range(30):
        blind.step()
    assert engine.pose("held").position[2] < before[2] - 0.5


def test_friction_is_that_of_the_thing(blind: MujocoBackend) -> None:
    """Slide on a slope of 25 degrees, whose tangent is 0.47."""
    slope = Pose.turned(np.array([0.0, 1.0, 0.0]), np.radians(25))
    floor = Fixture.model_validate({**TABLE, "friction": 1.0})
    moved = {}
    for friction in (0.3, 0.7):
        blind.reset(made_stage({}), None, np.random.default_rng(0))
        engine = blind.truth
        plate = SolidShape("box", (0.5, 0.5, 0.02))
        centre = np.array([1.5, 0.0, 0.0])
        engine.add(SceneObject("slope", plate, floor, 0.0, Pose(centre, slope.rotation)))
        surface = thing("it", BOX, 0, 0).surface.model_copy(update={"friction": friction})
        place = centre + slope.rotation @ [0.0, 0.0, 0.06]
        engine.add(SceneObject("it", BOX, surface, 0.3, Pose(place, slope.rotation)))
        for _ in range(36):
            blind.step()
        moved[friction] = float(np.linalg.norm(engine.pose("it").position - place))
    assert moved[0.7] < 1e-3
    # 0.6 s down the slope, less the loss by friction.
    expected = 0.5 * 0.6**2 * 9.81 * (np.sin(np.radians(25)) - 0.3 * np.cos(np.radians(25)))
    assert moved[0.3] == pytest.approx(expected, rel=0.05)


def nine_things(backend: MujocoBackend, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of nine objects on a table after a second, and some steps later."""
    backend.reset(made_stage({}, fixtures={"table": TABLE}), None, np.random.default_rng(0))
    engine = backend.truth
    shapes = [BOX, SolidShape.ball(0.05), SolidShape.cylinder(0.04, 0.1)]
    for row in range(3):
        for column, shape in enumerate(shapes):
            x, y = 0.45 + 0.15 * row, -0.4 + 0.4 * column
            engine.add(thing(f"thing_{row}_{column}", shape, x, y))
    targets = engine.read()[0]
    for _ in range(240):
        engine.step(targets)
    before = engine.solids.copy()
    for _ in range(steps):
        engine.step(targets)
    return before, engine.solids.copy()


def test_nine_things_rest_without_drift(blind: MujocoBackend) -> None:
    before, after = nine_things(blind, 10_000)
    assert np.abs(after - before)[1:, 4:7].max() < 1e-5


def test_repeats_are_the_same_to_the_last_bit(blind: MujocoBackend) -> None:
    first, again = (nine_things(blind, 500)[1] for _ in range(2))
    assert first.tobytes() == again.tobytes()

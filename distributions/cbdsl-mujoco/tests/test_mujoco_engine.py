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


def test_link_contacts_add_up_to_the_wrenches_of_the_fingertips(blind: MujocoBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    engine = blind.truth
    assert not list(engine.link_contacts())
    tips = {f"{side}_finger_{n}_tip": (f"{side}_hand", f"finger_{n}")
            for side in ("left", "right") for n in (1, 2, 3)}  # fmt: skip
    # Tips 2 mm deep in a fixture below them.
    for link in tips:
        place = engine.link_pose(link).position - [0.0, 0.0, 0.04 + 0.012 - 0.002]
        engine.add(SceneObject(link, BOX, Surface(), 0.0, Pose(place, np.eye(3))))
    touched: set[tuple[str, str]] = set()
    for _ in range(30):
        blind.step()
        forces = {cell: np.zeros(3) for cell in engine.cells}
        for contact in engine.link_contacts():
            assert not contact.is_link
            touched.add((contact.link, contact.other))
            if contact.link in tips:
                forces[tips[contact.link]] += contact.force
        wrenches = dict(zip(engine.cells, engine.wrenches(), strict=True))
        for cell, force in forces.items():
            assert force == pytest.approx(wrenches[cell][:3], abs=1e-6)
    assert {(link, link) for link in tips} <= touched


def test_links_that_press_on_each_other_are_contacts_of_links(blind: MujocoBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    engine = blind.truth
    target = engine.read()[0].copy()
    names = list(blind._joints.names)
    # Both arms swing across the middle.
    target[names.index("left_arm_1")], target[names.index("right_arm_1")] = 1.4, -1.4
    pairs = set()
    for _ in range(120):
        blind.apply(target)
        blind.step()
        pairs |= {frozenset((c.link, c.other)) for c in engine.link_contacts() if c.is_link}
    sides = {frozenset(link.partition("_")[0] for link in pair) for pair in pairs}
    assert frozenset(("left", "right")) in sides


def test_pushed_link_gives_way_until_the_push_ends(blind: MujocoBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    engine = blind.truth
    for _ in range(30):
        blind.step()
    rest = engine.link_pose("right_palm").position
    engine.push("right_palm", np.array([0.0, 20.0, 0.0]))
    for _ in range(30):
        blind.step()
    pushed = engine.link_pose("right_palm").position - rest
    assert pushed[1] > 5e-4 and pushed[1] > 3 * abs(pushed[0])
    engine.push("right_palm", np.zeros(3))
    for _ in range(60):
        blind.step()
    assert np.linalg.norm(engine.link_pose("right_palm").position - rest) < 0.2 * pushed[1]

"""The experimenter puts things where the stage says, and moves, holds and removes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.documents.stage import StageDocument
from tests.backends.conftest import Simulated, made_stage, run, stage_named

TABLE = {"form": {"shape": "box", "size": [2, 2, 0.1]}, "position": [1.5, 0, -0.45]}
TOP = -0.4
FORMS: dict[str, dict[str, Any]] = {
    "ball": {"shape": "ball", "radius": [0.04, 0.06]},
    "box": {"shape": "box", "size": [0.1, 0.2, [0.06, 0.1]]},
    "cylinder": {"shape": "cylinder", "radius": 0.05, "height": [0.08, 0.12]},
}
THINGS = {name: {"form": form, "mass": [0.2, 0.3]} for name, form in FORMS.items()}


def _stage(thing: str, place: dict[str, Any] | None = None, **context: Any) -> StageDocument:
    place = place or {"on": "table", "x": 1.5}
    return made_stage(
        {"things": [thing], "place": place, **context}, fixtures={"table": TABLE}, things=THINGS
    )


@pytest.mark.parametrize("name", FORMS)
def test_things_stand_still_on_their_fixture(unseeing: Simulated, name: str) -> None:
    for seed in range(3):
        place = {"on": "table", "x": [1.0, 1.5], "y": [-0.3, 0.3], "yaw": [-1, 1]}
        unseeing.reset(_stage(name, place), None, np.random.default_rng(seed))
        before = unseeing.truth.pose(name)
        assert 1.0 <= before.position[0] <= 1.5
        assert -0.3 <= before.position[1] <= 0.3
        assert 0.03 <= before.position[2] - TOP <= 0.06
        run(unseeing, 0.5)
        after = unseeing.truth.pose(name)
        assert after.position == pytest.approx(before.position, abs=1e-3)
        assert after.rotation == pytest.approx(before.rotation, abs=1e-2)


def test_gap_is_measured_from_the_surface(unseeing: Simulated) -> None:
    for seed in range(3):
        place = {"hand": "right_arm", "gap": 0.02, "held": True}
        unseeing.reset(_stage("ball", place), None, np.random.default_rng(seed))
        palm, ball = unseeing.truth.link_pose("right_palm"), unseeing.truth.pose("ball").position
        ahead = palm.rotation.T @ (ball - palm.position)
        assert ahead[:2] == pytest.approx([0, -0.006], abs=1e-6), "the robot file's tip offset"
        assert 0.02 + 0.04 <= ahead[2] <= 0.02 + 0.06


def test_things_are_drawn_evenly(unseeing: Simulated) -> None:
    stage = made_stage({"things": list(THINGS), "place": {"z": 1}}, things=THINGS)
    rng = np.random.default_rng(0)
    shown = []
    for _ in range(30):
        unseeing.reset(stage, None, rng)
        shown += unseeing.truth.names()
    assert len(shown) == 30
    assert min(shown.count(name) for name in THINGS) >= 4


@pytest.mark.parametrize("name", FORMS)
def test_carried_thing_keeps_its_velocity(unseeing: Simulated, name: str) -> None:
    motion = {"speed": 0.05, "direction": 2.0, "after": 0.1}
    unseeing.reset(_stage(name, motion=motion), None, np.random.default_rng(0))
    start = unseeing.truth.pose(name).position
    run(unseeing, 0.1)
    assert unseeing.truth.pose(name).position == pytest.approx(start, abs=1e-3)
    assert unseeing.observe().time == pytest.approx(0.1)
    run(unseeing, 1.0)
    travelled = unseeing.truth.pose(name).position - start
    assert travelled == pytest.approx([0.05 * np.cos(2), 0.05 * np.sin(2), 0], abs=2e-3)


@pytest.mark.parametrize("name", FORMS)
def test_shaken_thing_goes_to_and_fro(unseeing: Simulated, name: str) -> None:
    motion = {"speed": 0.3, "direction": np.pi / 2, "within": 0.04, "after": 0.1}
    unseeing.reset(_stage(name, motion=motion), None, np.random.default_rng(0))
    start = unseeing.truth.pose(name).position
    ways = []
    for _ in range(round(2.0 / unseeing.control_period)):
        unseeing.step()
        ways.append(unseeing.truth.pose(name).position - start)
    x, y, z = np.array(ways).T
    assert np.abs(x).max() < 2e-3 and np.abs(z).max() < 2e-3
    assert [y.min(), y.max()] == pytest.approx([-0.04, 0.04], abs=3e-3)
    # 7.5 rad/s: two whole swings and a part of the third.
    assert np.sum(np.diff(np.sign(y)) != 0) == pytest.approx(4, abs=1)


def test_carried_thing_is_left_alone_once_the_hand_touches_it(unseeing: Simulated) -> None:
    unseeing.reset(made_stage({}), None, np.random.default_rng(0))
    tip = unseeing.truth.link_pose("right_finger_1_tip").position
    shelf = {
        "form": {"shape": "box", "size": [0.8, 0.8, 0.02]},
        "position": [tip[0], tip[1], tip[2] - 0.04],
    }
    place = {"on": "shelf", "x": tip[0], "y": tip[1] + 0.2}
    block = {"form": {"shape": "box", "size": [0.08, 0.08, 0.08]}, "mass": 0.3}
    context = {
        "things": ["block"],
        "place": place,
        "motion": {"speed": 0.3, "direction": -np.pi / 2},
    }
    stage = made_stage(context, fixtures={"shelf": shelf}, things={"block": block})
    unseeing.reset(stage, None, np.random.default_rng(0))
    start = unseeing.truth.pose("block").position
    run(unseeing, 0.2)
    moved = unseeing.truth.pose("block").position - start
    assert moved == pytest.approx([0, -0.06, 0], abs=0.01)
    touched = False
    for _ in range(round(1.0 / unseeing.control_period)):
        unseeing.step()
        touched |= unseeing.truth.touched("block")
    assert touched
    assert np.linalg.norm(unseeing.truth.velocity("block")) < 0.02


def test_thrown_thing_flies_freely_from_its_time_on(unseeing: Simulated) -> None:
    motion = {"speed": 1.0, "direction": 0, "upward": 2.0, "thrown": True, "after": 0.2}
    unseeing.reset(_stage("ball", motion=motion), None, np.random.default_rng(0))
    start = unseeing.truth.pose("ball").position
    run(unseeing, 0.2)
    assert unseeing.truth.pose("ball").position == pytest.approx(start, abs=1e-3)
    run(unseeing, 0.3)
    flown = unseeing.truth.pose("ball").position - start
    assert flown == pytest.approx([0.3, 0, 2.0 * 0.3 - 9.81 * 0.3**2 / 2], abs=0.03)


def test_thing_is_removed_on_time(unseeing: Simulated) -> None:
    unseeing.reset(_stage("box", removed_after=0.25), None, np.random.default_rng(0))
    run(unseeing, 0.2)
    assert "box" in unseeing.truth.names()
    run(unseeing, 0.1)
    assert unseeing.truth.names() == ("table",)
    run(unseeing, 0.1)


@pytest.mark.parametrize("name", FORMS)
def test_fallen_object_is_put_back(unseeing: Simulated, name: str) -> None:
    place = {"z": 0.4, "x": 0.8, "y": 1.5, "yaw": 0.5}
    unseeing.reset(_stage(name, place, returned_after=0.3), None, np.random.default_rng(0))
    start, returns = unseeing.truth.pose(name), 0
    before = start.position[2]
    for _ in range(round(2.0 / unseeing.control_period)):
        unseeing.step()
        pose = unseeing.truth.pose(name)
        if pose.position[2] > before:
            returns += 1
            assert pose.position == pytest.approx(start.position, abs=0.05)
            assert pose.rotation == pytest.approx(start.rotation, abs=1e-2)
        assert pose.position[2] > start.position[2] - 0.2 - 2.5, "for 0.3 s, faster than 2 m/s"
        before = pose.position[2]
    assert returns >= 2


def test_resting_object_is_not_put_back(unseeing: Simulated) -> None:
    motion = {"speed": 0.3, "direction": 0.0}
    stage = _stage("box", motion=motion, returned_after=0.1)
    unseeing.reset(stage, None, np.random.default_rng(0))
    start = unseeing.truth.pose("box").position
    run(unseeing, 1.0)
    assert unseeing.truth.pose("box").position[0] == pytest.approx(start[0] + 0.3, abs=0.02)


@pytest.mark.parametrize("name", FORMS)
def test_held_object_stays_at_its_place(unseeing: Simulated, name: str) -> None:
    place = {"z": 0.4, "x": 0.8, "yaw": 0.5, "hand": "right_arm", "held": True}
    unseeing.reset(_stage(name, place), None, np.random.default_rng(0))
    before = unseeing.truth.pose(name)
    run(unseeing, 1.0)
    after = unseeing.truth.pose(name)
    assert after.position == pytest.approx(before.position, abs=1e-4)
    assert after.rotation == pytest.approx(before.rotation, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_moving_thing_stays_on_the_table(unseeing: Simulated, seed: int) -> None:
    unseeing.reset(stage_named("moving_right"), None, np.random.default_rng(seed))
    (name,) = set(unseeing.truth.names()) - {"table"}
    start = unseeing.truth.pose(name).position
    run(unseeing, 8.0)
    assert unseeing.truth.pose(name).position[2] == pytest.approx(start[2], abs=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_thrown_ball_ends_off_the_table(unseeing: Simulated, seed: int) -> None:
    unseeing.reset(stage_named("thrown"), None, np.random.default_rng(seed))
    run(unseeing, 5.0)
    assert unseeing.truth.pose("ball").position[2] < -1


def test_objects_of_out_of_reach_are_beyond_both_arms(unseeing: Simulated) -> None:
    fully_stretched = 0.55 + 0.3 + 0.06 + 0.076 + 0.151 + 0.012
    for seed in range(10):
        unseeing.reset(stage_named("out_of_reach"), None, np.random.default_rng(seed))
        (name,) = set(unseeing.truth.names()) - {"table", "pedestal"}
        for side in ("left", "right"):
            shoulder = unseeing.truth.link_pose(f"{side}_link_1").position
            distance = np.linalg.norm(unseeing.truth.pose(name).position - shoulder)
            assert distance - 0.1 > fully_stretched


def test_unknown_names_are_reported_with_the_known_ones(unseeing: Simulated) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(BackendError, match="thing 'cup'; there is: none"):
        unseeing.reset(made_stage({"things": ["cup"], "place": {"z": 0}}), None, rng)
    for place, complaint in (
        ({"on": "shelf"}, "fixture 'shelf'; there is: table"),
        ({"hand": "head", "gap": 0.02}, "'head', which has no tip"),
        ({"hand": "tail", "gap": 0.02}, "effector 'tail'; there is: .*head"),
    ):
        with pytest.raises(BackendError, match=complaint):
            unseeing.reset(_stage("ball", place), None, rng)

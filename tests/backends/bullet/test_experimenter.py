"""The experimenter puts things where the stage says, and moves, holds and removes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.stage import StageDocument
from tests.backends.bullet.conftest import made_stage, stage_named

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


def _run(backend: BulletBackend, seconds: float) -> None:
    for _ in range(round(seconds / backend.control_period)):
        backend.step()


@pytest.mark.parametrize("name", FORMS)
def test_things_stand_still_on_their_fixture(blind: BulletBackend, name: str) -> None:
    for seed in range(3):
        place = {"on": "table", "x": [1.0, 1.5], "y": [-0.3, 0.3], "yaw": [-1, 1]}
        blind.reset(_stage(name, place), None, np.random.default_rng(seed))
        before = blind.truth.pose(name)
        assert 1.0 <= before.position[0] <= 1.5
        assert -0.3 <= before.position[1] <= 0.3
        assert 0.03 <= before.position[2] - TOP <= 0.06
        _run(blind, 0.5)
        after = blind.truth.pose(name)
        assert after.position == pytest.approx(before.position, abs=1e-3)
        assert after.rotation == pytest.approx(before.rotation, abs=1e-2)


def test_a_gap_is_measured_from_the_surface(blind: BulletBackend) -> None:
    for seed in range(3):
        place = {"hand": "right_arm", "gap": 0.02, "held": True}
        blind.reset(_stage("ball", place), None, np.random.default_rng(seed))
        palm, ball = blind.truth.link_pose("right_palm"), blind.truth.pose("ball").position
        ahead = palm.rotation.T @ (ball - palm.position)
        assert ahead[:2] == pytest.approx([0, -0.006], abs=1e-6), "the robot file's tip offset"
        assert 0.02 + 0.04 <= ahead[2] <= 0.02 + 0.06


def test_things_are_drawn_evenly(blind: BulletBackend) -> None:
    stage = made_stage({"things": list(THINGS), "place": {"z": 1}}, things=THINGS)
    rng = np.random.default_rng(0)
    shown = []
    for _ in range(30):
        blind.reset(stage, None, rng)
        shown += blind.truth.names()
    assert len(shown) == 30
    assert min(shown.count(name) for name in THINGS) >= 4


@pytest.mark.parametrize("name", FORMS)
def test_a_carried_thing_keeps_its_velocity(blind: BulletBackend, name: str) -> None:
    motion = {"speed": 0.05, "direction": 2.0, "after": 0.1}
    blind.reset(_stage(name, motion=motion), None, np.random.default_rng(0))
    start = blind.truth.pose(name).position
    _run(blind, 0.1)
    assert blind.truth.pose(name).position == pytest.approx(start, abs=1e-3)
    assert blind.observe().time == pytest.approx(0.1)
    _run(blind, 1.0)
    travelled = blind.truth.pose(name).position - start
    assert travelled == pytest.approx([0.05 * np.cos(2), 0.05 * np.sin(2), 0], abs=2e-3)


def test_a_carried_thing_is_left_alone_once_the_hand_touches_it(blind: BulletBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    tip = blind.truth.link_pose("right_finger_1_tip").position
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
    blind.reset(stage, None, np.random.default_rng(0))
    start = blind.truth.pose("block").position
    _run(blind, 0.2)
    moved = blind.truth.pose("block").position - start
    assert moved == pytest.approx([0, -0.06, 0], abs=0.01)
    touched = False
    for _ in range(round(1.0 / blind.control_period)):
        blind.step()
        touched |= blind.truth.touched("block")
    assert touched
    assert np.linalg.norm(blind.truth.velocity("block")) < 0.02


def test_a_thrown_thing_flies_freely_from_its_time_on(blind: BulletBackend) -> None:
    motion = {"speed": 1.0, "direction": 0, "upward": 2.0, "thrown": True, "after": 0.2}
    blind.reset(_stage("ball", motion=motion), None, np.random.default_rng(0))
    start = blind.truth.pose("ball").position
    _run(blind, 0.2)
    assert blind.truth.pose("ball").position == pytest.approx(start, abs=1e-3)
    _run(blind, 0.3)
    flown = blind.truth.pose("ball").position - start
    assert flown == pytest.approx([0.3, 0, 2.0 * 0.3 - 9.81 * 0.3**2 / 2], abs=0.02)


def test_a_thing_is_removed_on_time(blind: BulletBackend) -> None:
    blind.reset(_stage("box", removed_after=0.25), None, np.random.default_rng(0))
    _run(blind, 0.2)
    assert "box" in blind.truth.names()
    _run(blind, 0.1)
    assert blind.truth.names() == ("table",)
    _run(blind, 0.1)


@pytest.mark.parametrize("name", FORMS)
def test_a_held_thing_stays_where_it_is(blind: BulletBackend, name: str) -> None:
    place = {"z": 0.4, "x": 0.8, "yaw": 0.5, "hand": "right_arm", "held": True}
    blind.reset(_stage(name, place), None, np.random.default_rng(0))
    before = blind.truth.pose(name)
    _run(blind, 1.0)
    after = blind.truth.pose(name)
    assert after.position == pytest.approx(before.position, abs=1e-4)
    assert after.rotation == pytest.approx(before.rotation, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_the_moving_thing_stays_on_the_table(blind: BulletBackend, seed: int) -> None:
    blind.reset(stage_named("moving_right"), None, np.random.default_rng(seed))
    (name,) = set(blind.truth.names()) - {"table"}
    start = blind.truth.pose(name).position
    _run(blind, 8.0)
    assert blind.truth.pose(name).position[2] == pytest.approx(start[2], abs=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_the_thrown_ball_ends_off_the_table(blind: BulletBackend, seed: int) -> None:
    blind.reset(stage_named("thrown"), None, np.random.default_rng(seed))
    _run(blind, 5.0)
    assert blind.truth.pose("ball").position[2] < -1


def test_what_is_out_of_reach_is_beyond_both_arms(blind: BulletBackend) -> None:
    fully_stretched = 0.55 + 0.3 + 0.06 + 0.076 + 0.151 + 0.012
    for seed in range(10):
        blind.reset(stage_named("out_of_reach"), None, np.random.default_rng(seed))
        (name,) = set(blind.truth.names()) - {"table", "pedestal"}
        for side in ("left", "right"):
            shoulder = blind.truth.link_pose(f"{side}_link_1").position
            distance = np.linalg.norm(blind.truth.pose(name).position - shoulder)
            assert distance - 0.1 > fully_stretched

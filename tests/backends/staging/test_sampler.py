"""Scenes of several objects: their sampled places, and their later states."""

from __future__ import annotations

from itertools import combinations, product
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.sampler import ScenarioSampler
from cbdsl.backends.staging.scenario import Scenario, SceneObject
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.convex import gap
from tests.backends.conftest import Simulated, made_stage, run, stage_named

TABLE = {"form": {"shape": "box", "size": [2, 2, 0.1]}, "position": [1.5, 0, -0.45]}
THINGS: dict[str, Any] = {
    "ball": {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.25},
    "box": {"form": {"shape": "box", "size": [0.1, 0.1, 0.08]}, "mass": 0.3},
}
ON_TABLE = {"on": "table", "x": [1.2, 1.6], "y": [-0.2, 0.2], "yaw": [-1, 1]}


def scene(fixtures: dict[str, Any] | None = None, **placed: Any) -> StageDocument:
    fixtures = {"table": TABLE, **(fixtures or {})}
    return made_stage({"placed": placed}, fixtures=fixtures, things=THINGS)


def drawn(stage: StageDocument, dexter: RobotDocument, seed: int) -> Scenario:
    def link_pose(link: str) -> Pose:
        raise AssertionError("nothing is in reach of a hand")

    sampler = ScenarioSampler(stage, dexter, link_pose, np.random.default_rng(seed))
    return sampler.sample(stage.contexts["only"])


def items(scenario: Scenario) -> dict[str, SceneObject]:
    return {thing.item.name: thing.item for thing in scenario.things}


def between(one: SceneObject, other: SceneObject) -> float:
    bodies = (each.shape.bodies(each.pose) for each in (one, other))
    return min(gap(a, b) for a, b in product(*bodies))


@pytest.mark.parametrize("seed", range(10))
def test_things_are_as_far_apart_as_asked_for(dexter: RobotDocument, seed: int) -> None:
    each = {"things": ["ball", "box"], "place": ON_TABLE}
    stage = scene(one={**each, "apart": 0.12}, two=each, three=each)
    shown = items(drawn(stage, dexter, seed))
    assert list(shown) == ["one", "two", "three"]
    assert between(shown["one"], shown["two"]) >= 0.12
    assert between(shown["one"], shown["three"]) >= 0.12
    assert between(shown["two"], shown["three"]) > 0.0


def test_scenes_that_fit_are_drawn_evenly(dexter: RobotDocument) -> None:
    """Two balls on a line are on each side equally often."""
    line = {"on": "table", "x": [1.2, 1.6]}
    stage = scene(
        one={"things": ["ball"], "place": line, "apart": 0.1},
        two={"things": ["ball"], "place": line},
    )
    sides = []
    for seed in range(200):
        shown = items(drawn(stage, dexter, seed))
        sides.append(shown["one"].pose.position[0] < shown["two"].pose.position[0])
    assert 75 <= sum(sides) <= 125


def test_thing_stands_on_another_in_its_frame(dexter: RobotDocument) -> None:
    stage = scene(
        upper={"things": ["ball"], "place": {"on": "lower", "x": 0.02, "y": 0.01}, "apart": 0.1},
        lower={"things": ["box"], "place": ON_TABLE},
    )
    shown = items(drawn(stage, dexter, 1))
    lower, upper = shown["lower"].pose, shown["upper"].pose
    relative = lower.rotation.T @ (upper.position - lower.position)
    assert relative == pytest.approx([0.02, 0.01, 0.09])


def test_thing_is_beside_another(dexter: RobotDocument) -> None:
    beside = {"name": "box", "by": [0.2, 0.3], "direction": [0, np.pi / 2]}
    stage = scene(
        box={"things": ["box"], "place": ON_TABLE},
        ball={"things": ["ball"], "place": {"beside": beside}},
    )
    for seed in range(10):
        shown = items(drawn(stage, dexter, seed))
        way = shown["ball"].pose.position - shown["box"].pose.position
        assert 0.2 <= np.hypot(*way[:2]) <= 0.3
        assert (way[:2] >= 0).all()
        assert way[2] == pytest.approx(0.05 - 0.04), "both stand equally low"


def test_object_on_a_fixture_follows_its_drawn_position(dexter: RobotDocument) -> None:
    pedestal = {
        "form": {"shape": "cylinder", "radius": 0.1, "height": 0.1},
        "position": [[0.8, 1.2], [-0.2, 0.2], -0.35],
    }
    place = {"on": "pedestal", "x": [-0.02, 0.02]}
    stage = made_stage(
        {"things": ["ball"], "place": place},
        fixtures={"table": TABLE, "pedestal": pedestal},
        things=THINGS,
    )
    places = set()
    for seed in range(10):
        scenario = drawn(stage, dexter, seed)
        at = scenario.fixtures[1].pose.position
        places.add(float(at[0]))
        assert 0.8 <= at[0] <= 1.2
        way = items(scenario)["ball"].pose.position - at
        assert abs(way[0]) <= 0.02
        assert way[1:] == pytest.approx([0.0, 0.1])
    assert len(places) == 10


def test_scene_without_room_names_both_objects(dexter: RobotDocument) -> None:
    there = {"things": ["ball"], "place": {"on": "table", "x": [1.2, 1.25]}}
    with pytest.raises(BackendError, match=r"most often .* 'one' and 'two' are less than 20 cm"):
        drawn(scene(one={**there, "apart": 0.2}, two=there), dexter, 0)
    with pytest.raises(BackendError, match="'one' overlaps 'wall'"):
        wall = {"form": {"shape": "box", "size": [0.5, 0.5, 0.5]}, "position": [1.2, 0, -0.1]}
        drawn(scene(fixtures={"wall": wall}, one=there), dexter, 0)


def test_relations_in_a_circle_are_refused(dexter: RobotDocument) -> None:
    stage = scene(
        one={"things": ["ball"], "place": {"on": "two"}},
        two={"things": ["box"], "place": {"beside": {"name": "one", "by": 0.2}}},
    )
    with pytest.raises(BackendError, match=r"in a circle: one -> two -> one|two -> one -> two"):
        drawn(stage, dexter, 0)


def test_every_thing_has_events_of_its_own(unseeing: Simulated) -> None:
    def at(y: float) -> dict[str, Any]:
        return {"on": "table", "x": 1.3, "y": y}

    ball = {"things": ["ball"]}
    stage = scene(
        still={**ball, "place": at(0.0)},
        removed={**ball, "place": at(0.2), "removed_after": 0.2},
        carried={**ball, "place": at(0.4), "motion": {"speed": 0.1, "direction": 0}},
        held={**ball, "place": {"z": 0.5, "x": 1.3, "held": True}, "released_after": 0.3},
        returned={**ball, "place": {"z": 0.5, "x": 1.3, "y": 1.5}, "returned_after": 0.1},
    )
    unseeing.reset(stage, None, np.random.default_rng(0))
    start = {name: unseeing.truth.pose(name).position for name in unseeing.truth.names()}
    run(unseeing, 0.25)
    shift = {n: unseeing.truth.pose(n).position - start[n] for n in unseeing.truth.names()}
    assert set(shift) == {"table", "still", "carried", "held", "returned"}
    assert shift["still"] == pytest.approx(0.0, abs=1e-3)
    assert shift["carried"] == pytest.approx([0.025, 0, 0], abs=3e-3)
    assert shift["held"] == pytest.approx(0.0, abs=1e-3)
    assert shift["returned"][2] < -0.2
    run(unseeing, 0.35)
    assert unseeing.truth.pose("held").position[2] < start["held"][2] - 0.2
    assert unseeing.truth.pose("returned").position[2] > start["returned"][2] - 0.7, "put back"


@pytest.mark.parametrize("name", ["three_things", "stacked"])
def test_objects_of_shipped_stages_rest(unseeing: Simulated, name: str) -> None:
    for seed in range(3):
        unseeing.reset(stage_named(name), None, np.random.default_rng(seed))
        start = {each: unseeing.truth.pose(each).position for each in unseeing.truth.names()}
        run(unseeing, 0.5)
        for each, before in start.items():
            assert unseeing.truth.pose(each).position == pytest.approx(before, abs=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_shipped_things_are_apart(unseeing: Simulated, seed: int) -> None:
    unseeing.reset(stage_named("three_things"), None, np.random.default_rng(seed))
    for one, other in combinations(("ball", "other_ball", "box"), 2):
        way = unseeing.truth.pose(one).position - unseeing.truth.pose(other).position
        assert np.linalg.norm(way) >= 0.12 + 0.08

"""Whole episodes: the same seed gives the same one, and its ending describes the events."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.runtime.episode import EpisodeError, Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from cbdsl.types.resource import Resource
from tests.conftest import Checked
from tests.runtime.conftest import GRIP, TABLE_BALL, Play, Played, made_stage, on_table
from tests.runtime.synthetic import Ball, SyntheticBackend, World


def somewhere(rng: np.random.Generator) -> World:
    """Return a world with a ball at a random place."""
    offset = np.array([*rng.uniform(-0.05, 0.05, 2), 0.0])
    return World(Ball(TABLE_BALL + offset, rng.uniform(0.05, 0.08)), GRIP)


def same(one: Observation, other: Observation) -> bool:
    arrays: Iterator[tuple[Any, Any]] = zip(
        (one.positions, one.velocities, *one.loads.values(), *one.images.values()),
        (other.positions, other.velocities, *other.loads.values(), *other.images.values()),
        strict=True,
    )
    return one.time == other.time and all(np.array_equal(a, b) for a, b in arrays)


def without_clock(played: Played) -> dict[str, object]:
    return asdict(replace(played.result, wall_seconds=0.0))


@pytest.mark.parametrize("name", ["searchtrack", "tactileprobe"])
def test_same_seed_gives_the_same_episode_to_the_bit(
    checked: Checked, play: Play, name: str
) -> None:
    first, again = (play(checked(name), somewhere, joints={"pan": 0.9}, seed=5) for _ in range(2))
    other = play(checked(name), somewhere, joints={"pan": 0.9}, seed=6)
    assert without_clock(first) == without_clock(again)
    assert first.transitions == again.transitions
    assert len(first.observations) == len(again.observations)
    assert all(map(same, first.observations, again.observations))
    assert without_clock(first) != without_clock(other)


@pytest.mark.parametrize("name", ["searchtrack", "tactileprobe", "reachtouch"])
def test_second_episode_is_independent_of_the_first(
    dexter: RobotDocument, urdf: Path, checked: Checked, name: str
) -> None:
    """Reset also remembered, felt and sampled values, and the last actions of controllers."""
    program, stage = checked(name), made_stage({"pan": 0.9})

    def made() -> Runner:
        backend = SyntheticBackend(dexter, urdf, somewhere)
        return Runner(dexter, Kinematics(dexter, urdf), program, backend)

    def told(runner: Runner) -> tuple[EpisodeResult, list[bytes]]:
        references: list[bytes] = []
        result = runner.run(
            stage,
            2,
            observer=EpisodeListeners(
                on_tick=lambda tick: references.append(tick.actuation.reference.tobytes())
            ),
        )
        return replace(result, wall_seconds=0.0), references

    used = made()
    used.run(stage, 1)
    assert told(used) == told(used) == told(made())


def test_result_counts_the_ticks_of_the_backend(checked: Checked, play: Play) -> None:
    played = play(checked("searchtrack"))
    result = played.result
    assert result.ticks == len(played.backend.applied) == len(played.observations) - 1
    assert result.sim_seconds == pytest.approx(played.observations[-1].time)
    assert (result.stage, result.context, result.seed) == ("made", "only", 0)
    assert result.renderer == played.backend.renderer


def test_listeners_receive_every_tick_and_transition_of_every_depth(
    checked: Checked, play: Play
) -> None:
    states: list[str] = []
    played = play(checked("reachtouch"), watch=lambda tick: states.append(tick.run.state))
    assert len(states) == played.result.ticks + 1
    changes = [a for a, b in zip(states, ["XXX", *states], strict=False) if a != b]
    assert changes == [each.next_state for each in played.at(0)]
    assert {each.program for each in played.at(1)} == {"searchtrack"}


def test_ending_of_a_success_names_the_levels_at_rest(checked: Checked, play: Play) -> None:
    ending = play(checked("reachtouch")).result.ending
    assert ending.startswith("Rewarded after")
    assert "in state X11" in ending
    assert "touch came to rest" in ending and "approach came to rest" in ending


@pytest.mark.parametrize(
    ("begin", "told", "joints", "far"),
    [
        (lambda rng: World(Ball(TABLE_BALL)), "touch closed on nothing", {}, ()),
        (
            lambda rng: World(Ball(np.array([1.45, -0.3, -0.1]), 0.1)),
            r"approach is stuck out of reach, [3-9]\d\.\d cm from stereo\.sat_10",
            {"pan": -0.2, "tilt": 0.6},
            ("approach",),
        ),
    ],
    ids=["closed on nothing", "out of reach"],
)
def test_ending_of_a_failure_names_the_missing_condition(
    checked: Checked,
    play: Play,
    begin: Callable[[np.random.Generator], World],
    told: str,
    joints: dict[str, float],
    far: tuple[str, ...],
) -> None:
    result = play(checked("reachtouch"), begin, joints=joints).result
    assert result.far == far
    assert not result.rewarded
    assert result.predicates[-1] == "X1-"
    assert result.ending.startswith("Not rewarded after")
    assert re.search(told, result.ending)
    assert "reachtouch has no action for state X1-" in result.ending


def test_absence_is_reported_by_the_signal_that_never_came(
    written: Callable[..., CheckedProgram], play: Play
) -> None:
    program = written(
        "controllers:\n"
        "  track: {potential: spring, reference: 0, feedback: cyclopean.red, effector: head}\n"
        "actions: [track]\npolicy: {'*': track}\nlimits: {transition_time: 1 s}\n"
    )
    result = play(program, lambda rng: World()).result
    assert "track had no cyclopean.red" in result.ending
    assert "track changed nothing in 1 s (state -)" in result.ending


def test_program_without_a_possible_reward_ends_as_done(checked: Checked, play: Play) -> None:
    result = play(checked("posture")).result
    assert not result.rewarded
    assert result.ending.startswith("Done after")


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_broken_sensor_stops_the_robot(checked: Checked, play: Play, value: float) -> None:
    seen: list[float] = []

    def direct(world: World, time: float) -> None:
        if time > 0.2:
            world.broken["right_hand", "finger_2"] = np.full(6, value)

    def watch(tick: Tick) -> None:
        seen.append(tick.observation.time)

    with pytest.raises(EpisodeError, match=r"0\.2. s: .* right_hand\.finger_2"):
        play(checked("searchtrack"), lambda rng: on_table(), direct, watch=watch)
    assert seen[-1] == pytest.approx(0.2)


def test_unread_signals_are_not_observed(checked: Checked) -> None:
    resources = resources_of(checked("reachtouch"))
    assert all(isinstance(resource, Resource) for resource in resources)
    names = {resource.name for resource in resources}
    assert {"cyclopean.sat_10", "stereo.sat_10", "head.uniform", "right_arm.home"} <= names
    assert not any(name.startswith(("left_arm", "left_hand")) for name in names)

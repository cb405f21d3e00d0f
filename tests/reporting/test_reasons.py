"""Reasons for the end of an episode: each is reported only where it applies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.reporting.reasons import reasons
from cbdsl.reporting.recorded import Recorded, read_recording
from tests.reporting.conftest import Record
from tests.runtime.synthetic import World

TICKS = 60


def made(**changes: Any) -> Recorded:
    """Return an episode of a second in which ``above`` and ``below`` get their full velocity."""
    triple = {"feedback": "arm.position", "reference": "", "potential": "spring"}
    summary = {
        "controllers": ["above", "below"],
        "joints": ["shoulder", "elbow"],
        "predicates": ["00"] * TICKS,
        "triples": {"above": triple, "below": {**triple, "reference": "seen"}},
        "signals": {"arm.position": {}, "seen": {}},
        "robot": {"singular_value": 0.04},
        "guards": ["right_hand", "right_arm"],
    }
    ones = np.ones((TICKS, 2))
    arrays: dict[str, Any] = {
        "time": np.arange(TICKS) / 60,
        "potentials": ones,
        "level_priority": (ones * [0, 1]).astype(int),
        "level_share": ones,
        "level_rank": 3 * ones.astype(int),
        "level_singular_value": ones,
        "level_held_by": -ones.astype(int),
        "at_limits": np.zeros((TICKS, 2), dtype=bool),
        "guard_held": np.zeros((TICKS, 2), dtype=bool),
        "signal_arm.position": np.zeros((TICKS, 3)),
        "signal_seen": np.zeros((TICKS, 3)),
    }
    for key, value in changes.items():
        (summary if key in summary else arrays)[key.replace("__", ".")] = value
    return Recorded(Path("made.json"), summary, arrays)


def late(value: float, column: int = 1, usual: float = 1.0) -> np.ndarray:
    """Return ``usual`` for both levels, and ``value`` for one of them in the last 0.6 s."""
    array = np.full((TICKS, 2), usual)
    array[24:, column] = value
    return array


def test_reasons_without_an_obstacle_are_empty() -> None:
    assert reasons(made()) == []


def test_a_missing_resource_is_reported_with_its_last_time() -> None:
    seen = np.zeros((TICKS, 3))
    seen[31:] = np.nan
    predicates = ["00"] * 31 + ["0-"] * 29
    (told,) = reasons(made(predicates=predicates, signal_seen=seen))
    assert told == "below had no seen, last at 0.5 s."
    (told,) = reasons(made(predicates=predicates, signal_seen=np.full((TICKS, 3), np.nan)))
    assert told == "below had no seen in the whole episode."
    (told,) = reasons(made(predicates=predicates))
    assert "without a held object its effector does not move its feedback" in told


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"level_held_by": late(0, usual=-1).astype(int)}, "because above above it needed"),
        ({"level_held_by": late(2, usual=-1).astype(int)}, "joints were at their limits"),
        ({"level_rank": late(0).astype(int)}, "none of its directions was left"),
        ({"level_singular_value": late(0.01)}, "close to a singularity"),
        ({}, "its step was as long as a step may be"),
    ],
)
def test_a_restricted_level_is_reported_with_the_cause(changes: dict[str, Any], named: str) -> None:
    (told,) = reasons(made(level_share=late(0.1), **changes))
    assert told.startswith("below got 10 % of what it wanted, ") and named in told
    (told,) = reasons(made(level_share=late(-0.4), **changes))
    assert told.startswith("below was moved away from what it wanted, ") and named in told


def test_arrived_level_gives_no_reason() -> None:
    assert reasons(made(level_share=late(0.1), potentials=late(1e-6))) == []


def test_short_restriction_gives_no_reason() -> None:
    share = np.ones((TICKS, 2))
    share[-5:] = 0.0
    assert reasons(made(level_share=share)) == []


def test_guards_that_held_are_named() -> None:
    (told,) = reasons(made(guard_held=late(1, usual=0).astype(bool)))
    assert told == "Gave way to the guards of: right_arm."


def test_joints_at_limits_are_named() -> None:
    (told,) = reasons(made(at_limits=late(1, usual=0).astype(bool)))
    assert told == "At their limits: elbow."


def test_reasons_without_an_active_level_are_empty() -> None:
    assert reasons(made(level_priority=-np.ones((TICKS, 2), dtype=int))) == []


@pytest.mark.slow
def test_episode_without_an_object_names_the_missing_signal(record: Record) -> None:
    told = reasons(read_recording(record("searchtrack", begin=lambda rng: World())))
    assert "track had no cyclopean.sat_10 in the whole episode." in told

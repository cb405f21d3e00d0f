"""Places of expected motion, from kept episodes and from new ones."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cbdsl_reproduction.chapter_5.fig_5_2 import run, seeds_of
from cbdsl_reproduction.chapter_5.motion_episodes import (
    NOTHING,
    SHAKEN,
    MotionEpisode,
    motion_digest,
    run_motion_episodes,
)
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_trials import KeptTrials
from cbdsl_reproduction.quantity import Quantity, Verdict

TRIALS = 20


def outcome(folder: Path, *, spread: float, phantoms: bool) -> Result:
    """Return the result of trials that track each shaken object, and ``phantoms`` if requested."""
    path, rng = folder / "motion_kinematic_None.jsonl", np.random.default_rng(0)
    for context in (SHAKEN, NOTHING):
        kept = KeptTrials(path, motion_digest(context), MotionEpisode)
        for trial in range(TRIALS):
            for seed in seeds_of(trial, context, 0):
                pan, tilt = np.array((0.0, 0.4)) + rng.uniform(-spread, spread, 2)
                posture = (pan, tilt) if context == SHAKEN else (1.3, 0.0) if phantoms else ()
                off = math.radians(2.0) if context == SHAKEN else math.nan
                kept.add(MotionEpisode(context, seed, posture, off, ""))
    return run(RunSettings(folder=folder, trials=TRIALS))


def judged(result: Result) -> dict[str, Quantity]:
    return {each.name: each for each in result.quantities if each.expected is not None}


def test_half_of_the_episodes_are_shaken_and_no_seed_is_used_twice() -> None:
    seeds = [s for trial in range(3) for c in (SHAKEN, NOTHING) for s in seeds_of(trial, c, 7)]
    assert sorted(seeds) == list(range(7, 7 + 75))
    assert (len(seeds_of(0, SHAKEN, 0)), len(seeds_of(0, NOTHING, 0))) == (13, 12)


def test_samples_at_one_place_give_a_single_peak(tmp_path: Path) -> None:
    quantities = judged(outcome(tmp_path, spread=0.08, phantoms=False))
    assert {each.verdict for each in quantities.values()} == {Verdict.REPRODUCED}


def test_motion_seen_in_a_still_scene_gives_another_peak(tmp_path: Path) -> None:
    quantities = judged(outcome(tmp_path, spread=0.08, phantoms=True))
    assert quantities["motion tracked where nothing moves"].verdict is Verdict.MISSED
    assert quantities["trials whose density has a single peak"].verdict is Verdict.MISSED


def test_samples_spread_over_the_room_give_no_single_peak(tmp_path: Path) -> None:
    quantities = judged(outcome(tmp_path, spread=0.9, phantoms=False))
    assert quantities["trials whose density has a single peak"].verdict is Verdict.MISSED


@pytest.mark.parametrize("engine", ["kinematic", "mujoco"])
def test_shaken_object_is_tracked_and_resting_one_is_not(engine: str) -> None:
    (found,) = run_motion_episodes(SHAKEN, [1], engine, "ideal")
    assert len(found.posture) == 2 and found.off < math.radians(5), found.ending
    (nothing,) = run_motion_episodes(NOTHING, [1], engine, "ideal")
    assert nothing.posture == () and math.isnan(nothing.off)


@pytest.mark.slow
def test_a_resting_head_sees_motion_in_pixels_and_no_other() -> None:
    # With one of these seeds, none of the ten looks is at the object.
    episodes = [*run_motion_episodes(SHAKEN, range(1, 7), "bullet", None)]
    assert all(each.off < math.radians(5) for each in episodes if each.posture)
    assert sum(bool(each.posture) for each in episodes) == 5
    (nothing,) = run_motion_episodes(NOTHING, [2], "bullet", None)
    assert nothing.posture == ()

"""Comparison of learners by the reward during learning, continued from kept trials."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_experience import experience

from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition
from cbdsl_reproduction.chapter_5 import three_learners
from cbdsl_reproduction.chapter_5.retries import retries
from cbdsl_reproduction.chapter_5.three_learners import (
    LearnerTrials,
    dip_length,
    quantities_of,
    stable_at,
)
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.handedness_series import (
    BRIEF,
    CONCURRENT,
    FLAT,
    STAGED,
    HandednessSeries,
)
from cbdsl_reproduction.quantity import Quantity, Verdict

TRIALS, EPISODES, FIRST = 100, 200, 25


def learned(series: HandednessSeries, chances: np.ndarray, seed: int) -> LearnerTrials:
    """Return trials whose episodes are rewarded by chance, in one transition each."""
    rng = np.random.default_rng(seed)
    trials = tuple(
        tuple(experience(("XX", "a", "X1"), reward=int(rng.random() < p)) for p in chances)
        for _ in range(TRIALS)
    )
    return LearnerTrials(series, trials, 1.0, series.constrained)


def step(at: int, low: float = 0.05) -> np.ndarray:
    return np.where(np.arange(EPISODES) < at, low, 0.8)


def dipping() -> np.ndarray:
    chances = step(10)
    chances[FIRST : FIRST + 10] = 0.2
    return chances


def rows(flat: np.ndarray, concurrent: np.ndarray, staged: np.ndarray) -> list[Quantity]:
    curves = {FLAT: flat, CONCURRENT: concurrent, BRIEF: concurrent, STAGED: staged}
    groups = [learned(each, curve, seed) for seed, (each, curve) in enumerate(curves.items())]
    return list(quantities_of(groups, 0))


def test_sources_curves_are_reproduced() -> None:
    quantities = rows(step(140), step(50), dipping())
    assert len(quantities) == 11
    assert {each.verdict for each in quantities} == {Verdict.REPRODUCED}


def test_equal_learners_are_not_in_order_and_a_level_curve_has_no_drop() -> None:
    quantities = rows(step(10), step(10), step(10))
    equal, staged, concurrent, flat_settles, *_, drop, _ = quantities
    assert equal.verdict is not Verdict.REPRODUCED
    assert staged.verdict is not Verdict.REPRODUCED
    assert concurrent.verdict is not Verdict.REPRODUCED
    assert flat_settles.verdict is Verdict.MISSED
    assert drop.verdict is not Verdict.REPRODUCED


def test_curve_without_reward_never_settles() -> None:
    never = np.full((TRIALS, EPISODES), 0.01)
    assert stable_at(never) > EPISODES
    settles = rows(np.full(EPISODES, 0.01), step(50), dipping())[3]
    assert np.isnan(settles.ours)
    assert settles.verdict is Verdict.MISSED


@pytest.mark.parametrize("length", [4, 10, 30])
def test_dip_length_returns_the_length_of_a_drop(length: int) -> None:
    curve = np.full((3, EPISODES), 0.8)
    curve[:, FIRST : FIRST + length] = 0.1
    assert abs(dip_length(curve, FIRST) - length) <= 1


def _moved(state: str, after: str, allocation: str) -> Transition:
    return Transition("reachtouch", 0, 0.0, state, "a", after, 1, 0, (), allocation)


def test_retry_is_made_with_other_resources() -> None:
    there, same = _moved("X0-", "X1-", "right_arm"), _moved("X1-", "X0-", "right_arm")
    episode = Experience("left", 0, (there, same), {}, 2, 0.1)
    assert not list(retries(episode))
    other = replace(same, allocation="left_arm")
    assert list(retries(replace(episode, transitions=(there, other)))) == [other]


@pytest.mark.slow
def test_experiment_resumes_from_kept_trials(tmp_path: Path) -> None:
    settings = RunSettings(seed=8450000, quick=True, trials=1, folder=tmp_path)
    whole = three_learners.run(settings, "fig-5.8")
    journals = sorted(tmp_path.rglob("*.episodes.jsonl"))
    assert len(journals) == 6, "four learners, and the best policies of two kinds of actions"
    before = [journal.read_text().splitlines() for journal in journals]
    for journal, lines in zip(journals, before, strict=True):
        journal.write_text("".join(f"{line}\n" for line in lines[:4]))
    resumed = three_learners.run(settings, "fig-5.8")
    # Some are NaN, which is unequal to itself.
    assert repr(resumed.quantities) == repr(whole.quantities)
    after = [journal.read_text().splitlines() for journal in journals]
    assert [_timeless(lines) for lines in after] == [_timeless(lines) for lines in before]
    (diagram,) = three_learners.run(settings, "fig-5.9").charts
    assert "<svg" in diagram.svg()


def _timeless(lines: list[str]) -> list[str]:
    """Return lines of a journal without the wall time of each episode."""
    return [line.partition('"wall_seconds"')[0] for line in lines]

"""Episodes until three successful checks in a row, and the share of trials that never learn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import pytest
from drawn_experience import experience

from cbdsl_reproduction.chapter_4.checks import Check, Schedule
from cbdsl_reproduction.chapter_4.learned_in import (
    learned_in,
    learned_in_claims,
    learned_in_quantities,
)
from cbdsl_reproduction.region import near
from cbdsl_reproduction.series import COARTICULATED

HELD_OUT = 20


def checks(*rewarded: int) -> list[Check]:
    """Return one check every five episodes, with these numbers of rewards among HELD_OUT."""
    step = ("XX", "track", "X1")
    return [
        Check(
            5 * (place + 1),
            tuple(experience(step, reward=int(n < count)) for n in range(HELD_OUT)),
        )
        for place, count in enumerate(rewarded)
    ]


@pytest.mark.parametrize(
    ("rewarded", "episodes"),
    [
        ((20, 20, 20), 5),
        ((19, 19, 19), 5),
        ((18, 20, 20, 20), 10),
        ((20, 20, 18, 20, 20, 20), 20),
        ((20, 20), math.inf),
        ((20, 20, 18, 20, 20), math.inf),
        ((), math.inf),
    ],
)
def test_learned_in_requires_three_successful_checks_in_a_row(
    rewarded: Sequence[int], episodes: float
) -> None:
    assert learned_in(COARTICULATED, checks(*rewarded)) == episodes


def test_contexts_without_a_reward_do_not_count() -> None:
    step = ("XX", "track", "X-")
    series = replace(COARTICULATED, hopeless=frozenset({"absent"}))
    check = Check(5, (experience(step, reward=1), experience(step, context="absent")))
    assert check.success(series) == 1
    assert check.success(COARTICULATED) == 0.5
    assert Check(5, (experience(step, context="absent"),)).success(series) == 0


def test_median_includes_trials_that_never_learn() -> None:
    trials = [checks(20, 20, 20), checks(0, 20, 20, 20), checks(0, 0, 0)]
    claims = learned_in_claims("", COARTICULATED, "", near(10, 1))
    middle, never = learned_in_quantities(COARTICULATED, trials, claims, seed=0)
    assert middle.ours == 10
    assert middle.interval is not None and middle.interval[1] == math.inf
    assert never.ours == pytest.approx(100 / 3)
    lost, _ = learned_in_quantities(COARTICULATED, [checks(0, 0, 0)], claims, seed=0)
    assert math.isnan(lost.ours) and lost.interval is None


def test_schedule_ends_with_the_trial() -> None:
    assert list(Schedule(every=5, held_out=1).after(25)) == [5, 10, 15, 20, 25]

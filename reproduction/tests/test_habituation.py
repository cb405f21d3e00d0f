"""Counts and measures of explorations, on synthetic catalogs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cbdsl.documents.catalog import AffordanceSection
from cbdsl_reproduction.bar_chart import Bar, BarChart
from cbdsl_reproduction.chapter_6.action_counts import tally
from cbdsl_reproduction.chapter_6.catalogs import (
    _afforded,
    _counts,
    _habituation,
    _shares,
    claims_of,
)
from cbdsl_reproduction.chapter_6.habituation import (
    change_chart,
    negligible_after,
    reward_chart,
    rewards_by_hindsight,
    tries_until_habituated,
)
from cbdsl_reproduction.quantity import Verdict
from tests.training.drawn_catalog import TEN, catalog


def test_counts_are_of_all_trials() -> None:
    assert tally([TEN, TEN], "reachtouch") == (8, 10)
    assert tally([TEN], "visualinspect") == (0, 0)
    assert _afforded(TEN) == {"reachtouch", "searchtrack"}
    (taken, *_) = _counts(claims_of("fig-6.2"), [TEN, TEN])
    assert (taken.name, taken.ours) == ("reachtouch taken", 5.0)


def test_afforded_with_a_found_mark_leaves_the_open_inspection_out() -> None:
    """Count a rewarded open inspection by itself only where no mark of it was rewarded."""
    open_one, mark = "visualinspect", "visualinspect_blue"
    rows = {
        name: AffordanceSection(program=open_one, tried=2, rewarded=1) for name in (open_one, mark)
    }
    found = {**TEN.affordances, **rows}
    assert _afforded(TEN.model_copy(update={"affordances": found})) - _afforded(TEN) == {mark}
    del found[mark]
    assert _afforded(TEN.model_copy(update={"affordances": found})) - _afforded(TEN) == {open_one}


def test_action_that_fails_too_often_is_a_miss() -> None:
    often, _, seldom, none = _shares(claims_of("fig-6.2"), [TEN] * 200)
    assert often.verdict is Verdict.REPRODUCED and often.ours == 100
    reachtouch = next(
        each for each in _shares(claims_of("fig-6.2"), [TEN] * 200) if "reach" in each.name
    )
    assert reachtouch.verdict is Verdict.MISSED and reachtouch.ours == pytest.approx(80)
    assert math.isnan(seldom.ours) and math.isnan(none.ours)


@pytest.mark.parametrize(
    ("rewards", "after"),
    [
        ([0.0] * 40, 0.0),
        ([1.0] + [0.0] * 39, 10.0),
        ([1.0] * 20 + [0.0] * 30, 29.0),
        ([0.0] * 39 + [1.0], math.inf),
        ([1.0] * 5, math.inf),
    ],
)
def test_negligible_after_returns_the_action_from_which_rewards_stay_small(
    rewards: list[float], after: float
) -> None:
    assert negligible_after(np.array(rewards)) == after


def test_action_is_taken_until_its_model_changes_by_less_than_a_tenth() -> None:
    assert tries_until_habituated(TEN, "reachtouch") == 5
    assert tries_until_habituated(TEN, "searchtrack") == 2
    assert tries_until_habituated(TEN, "bimanualtouch") == 0


def test_by_hindsight_every_change_is_relative_to_the_largest_of_the_trial() -> None:
    (row,) = rewards_by_hindsight([TEN])
    assert row[0] == pytest.approx(0.95) and row[3] == pytest.approx(0.2)
    assert row[5] == 0.0 and row[1] == -0.05


def test_rising_share_of_noop_is_reproduced() -> None:
    growing = catalog("T" * 40 + "." * 40, [1.0] * 40 + [0.0] * 40)
    *_, grows = _habituation(claims_of("fig-6.2"), [growing] * 5, seed=1)
    assert grows.ours == 30 and grows.verdict is Verdict.REPRODUCED
    still = catalog("T" * 80, [1.0] * 80)
    *_, stays = _habituation(claims_of("fig-6.2"), [still] * 5, seed=1)
    assert stays.verdict is not Verdict.REPRODUCED


def test_chart_has_one_point_per_measured_action() -> None:
    chart = reward_chart("fig", "made", [TEN, TEN])
    assert [len(line.y) for line in chart.lines] == [10, 10] and chart.lines[0].low
    change = change_chart("fig", "made", [TEN])
    assert change is not None and change.lines[0].y[:3] == (1.0, 0.5, 0.25)
    bars = BarChart("fig", "made", (Bar("touch <1>", 3, 1), Bar("noop", 0, 2)), "rewarded", "not")
    assert "touch &lt;1&gt;" in bars.svg() and "3 + 1" in bars.svg()
    assert bars.data()["noop"] == {"rewarded": 0, "not": 2}
    one = BarChart("fig", "made", (Bar("dPz", 0.5),), "share of trials")
    assert one.data() == {"dPz": {"share of trials": 0.5}}
    assert "> 0.5<" in one.svg() and " + " not in one.svg()

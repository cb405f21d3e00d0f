"""Affordances of single and stacked objects, from kept trials and from a new one."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl_reproduction.affordance_trials import (
    AffordanceTrial,
    affordance_digest,
    attempt,
    run_affordances,
)
from cbdsl_reproduction.chapter_7.fig_7_17 import AFFORDED, run
from cbdsl_reproduction.constellation_trials import ConstellationTrial, constellation_digest
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.growing_stack_trials import (
    CONTEXT,
    ORDER,
    GrowingStack,
    growing_digest,
    run_growing_stacks,
)
from cbdsl_reproduction.kept_trials import KeptTrials
from cbdsl_reproduction.quantity import Verdict
from cbdsl_reproduction.trial_record import plain_data, read_record

TRIALS = 30
ROUND, LONG = (0.0, 0.1, 0.05, 0.05), (0.0, 0.0, 0.1, 0.05, 0.7)
PAIRS = ("purple_box_on_blue_box", "football_on_purple_box")


def outcome(folder: Path, *, lifted: bool, stands: bool) -> Result:
    """Return the result of thirty trials each; ``lifted`` refers to the blue box."""
    name = "mujoco_ideal.jsonl"
    for thing, own in AFFORDED.items():
        for program in own:
            what = attempt(program, thing)
            kept = KeptTrials(
                folder / f"affordances_{name}", affordance_digest(what), AffordanceTrial
            )
            for seed in range(TRIALS):
                done = lifted if (program, thing) == ("bimanualtouch", "blue_box") else True
                kept.add(AffordanceTrial(what, seed, done, ""))
    for pair in PAIRS:
        pairs = KeptTrials(
            folder / f"constellations_{name}",
            constellation_digest(pair),
            ConstellationTrial,
        )
        for seed in range(TRIALS):
            pairs.add(ConstellationTrial(pair, seed, True, stands, {}, {"offset": (0.0, 0.1)}, ""))
    stacks = KeptTrials(folder / f"growing_stacks_{name}", growing_digest(CONTEXT), GrowingStack)
    view = {"blue_box": LONG, "football": ROUND}
    for seed in range(TRIALS):
        stacks.add(GrowingStack(CONTEXT, seed, True, stands, (view, view, view), ""))
    return run(RunSettings(folder=folder, trials=TRIALS, backend="mujoco", cameras="ideal"))


def verdicts(result: Result) -> dict[str, Verdict]:
    return {each.name: each.verdict for each in result.quantities if each.expected is not None}


def test_outcome_as_in_the_source_is_reproduced(tmp_path: Path) -> None:
    result = outcome(tmp_path, lifted=False, stands=True)
    assert set(verdicts(result).values()) == {Verdict.REPRODUCED}
    assert [each.name for each in result.charts] == ["fig-7.16", "fig-7.17"]
    assert result.charts[0].svg().count("blob ") == 6


def test_lifted_box_and_falling_stack_are_missed(tmp_path: Path) -> None:
    result = outcome(tmp_path, lifted=True, stands=False)
    missed = {name for name, verdict in verdicts(result).items() if verdict is Verdict.MISSED}
    assert missed == {
        "blue box: bimanualtouch rewarded",
        "share of truly standing stacks among those reported as standing",
    }
    # Stacks that fall are not shown as standing.
    assert [each.name for each in result.charts] == ["fig-7.17"]


def test_hierarchy_has_the_pair_below_the_stack(tmp_path: Path) -> None:
    nodes = outcome(tmp_path, lifted=False, stands=True).charts[1].data()
    stack = nodes["football_on_purple_box_on_blue_box"]
    assert stack == {
        "below": ["purple_box_on_blue_box", "football"],
        "affords": {"constellations": [TRIALS, TRIALS]},
    }


@pytest.mark.slow
def test_stack_of_three_is_tracked_once_it_stands() -> None:
    (trial,) = run_growing_stacks(CONTEXT, [11], "mujoco", "ideal")
    assert trial.tracked and trial.stands, trial.ending
    first, second, last = trial.views
    assert first.keys() == last.keys() == set(ORDER)
    # In the image, an object that is set on another one comes nearer to it.
    lower = [abs(v["purple_box"][0] - v["blue_box"][0]) for v in (first, second, last)]
    upper = [abs(v["football"][0] - v["purple_box"][0]) for v in (first, last)]
    assert max(lower[1:]) < lower[0] / 2 and upper[1] < upper[0] / 2
    assert read_record(GrowingStack, json.loads(json.dumps(plain_data(trial)))) == trial


@pytest.mark.slow
def test_small_box_is_transferred_and_a_large_one_is_touched() -> None:
    for what in (attempt("bimanualtouch", "purple_box"), attempt("reachtouch", "blue_box")):
        (trial,) = run_affordances(what, [1], "mujoco", "ideal")
        assert trial.rewarded, trial.ending

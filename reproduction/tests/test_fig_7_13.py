"""Signs and impedances of pairs, from kept trials."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cbdsl.learning.impedance import DIRECTIONS, ImpedanceProfile, ImpedanceTest
from cbdsl_reproduction.chapter_7.fig_7_13 import run
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.impedance_trials import ImpedanceTrial, impedance_digest
from cbdsl_reproduction.kept_trials import KeptTrials
from cbdsl_reproduction.quantity import Verdict
from cbdsl_reproduction.thing_pairs import ALL_PAIRS, PAIRS

TRIALS = 20


def profile(stiff: set[str]) -> ImpedanceProfile:
    return ImpedanceProfile(
        tuple(
            ImpedanceTest(
                name, sign, 0.01 * sign, 2.0 if name in stiff else 0.1, name in stiff, 0.0
            )
            for name in DIRECTIONS
            for sign in (1, -1)
        )
    )


def keep(folder: Path, *, right: bool) -> RunSettings:
    for name, pair in PAIRS.items():
        kept = KeptTrials(folder / "mujoco_ideal.jsonl", impedance_digest(name), ImpedanceTrial)
        stiff = set(pair.stiff) if right else set(DIRECTIONS) - set(pair.stiff)
        for seed in range(TRIALS):
            kept.add(ImpedanceTrial(name, seed, profile(stiff), "", 60.0))
    return RunSettings(folder=folder, trials=TRIALS, backend="mujoco", cameras="ideal")


@pytest.mark.slow
def test_signs_of_a_profile_are_no_independent_trials(tmp_path: Path) -> None:
    """Two profiles with six correct signs each are two trials, not twelve."""
    result = run(replace(keep(tmp_path, right=True), trials=2))
    judged = [each for each in result.quantities if each.expected is not None]
    assert all(each.note.endswith(" in 2 trials") for each in judged)
    assert {each.ours for each in judged} == {100.0}
    assert {each.verdict for each in judged} == {Verdict.UNDECIDED}


@pytest.mark.parametrize(
    ("right", "verdict"), [(True, Verdict.REPRODUCED), (False, Verdict.MISSED)]
)
def test_signs_are_judged(tmp_path: Path, *, right: bool, verdict: Verdict) -> None:
    result = run(keep(tmp_path, right=right))
    judged = [each for each in result.quantities if each.expected is not None]
    assert len(judged) == len(PAIRS)
    assert {each.verdict for each in judged} == {verdict}


@pytest.mark.slow
def test_charts_show_shares_of_trials_and_of_the_largest_impedance(tmp_path: Path) -> None:
    charts = {chart.name: chart.data() for chart in run(keep(tmp_path, right=True)).charts}
    assert len(charts) == 2 * len(PAIRS)
    assert charts["fig-7.13-cylinder_in_cylinder"]["dPx"] == {"share of trials": 1.0}
    assert charts["fig-7.13-cylinder_in_cylinder"]["dRz"] == {"share of trials": 0.0}
    shares = charts["fig-7.14-cylinder_in_cylinder"]
    assert shares["dPz"] == {"share of the largest": pytest.approx(0.05)}


def test_direction_is_not_both_stiff_and_free() -> None:
    for pair in ALL_PAIRS.values():
        assert set(pair.judged) <= set(DIRECTIONS)
        assert len(set(pair.judged)) == len(pair.judged)

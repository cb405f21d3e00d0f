"""Bimanual grasp: a box is taken in both hands and brought nearer."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.chapter_3.fig_3_5 import _force_errors, _quantities, run
from cbdsl_reproduction.chapter_3.inspection import InspectionRun, Look
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict


def pressed(*forces: float) -> InspectionRun:
    return InspectionRun(forces=[np.array([force, 10.0]) for force in forces])


def test_forces_are_kept_within_a_tenth_and_a_box_without_any_is_not_held() -> None:
    kept = [pressed(10.0, 11.9)] * 60
    assert _force_errors(kept).verdict is Verdict.REPRODUCED
    astray = _force_errors(kept[:30] + [pressed(12.1, 12.1)] * 30)
    assert astray.verdict is not Verdict.REPRODUCED and astray.note.startswith("30 of 60")
    dropped = _force_errors(kept[:30] + [pressed()] * 30)
    assert dropped.verdict is not Verdict.REPRODUCED and dropped.note.startswith("30 of 60")


def test_ratios_compare_the_ends_of_the_same_trial() -> None:
    """Leave out the first trial, whose box was never in both hands."""
    picture = np.zeros((1, 1, 3), np.uint8)
    table = [Look(picture, 0.5, phi) for phi in (100.0, 2.0, 4.0)]
    runs = [InspectionRun(), InspectionRun(phis=[1.0, 0.5]), InspectionRun(phis=[2.0, 1.0])]
    ours = {each.name: each.ours for each in _quantities(table, runs, seed=1)}
    assert ours["φ_l on the table by φ_l, held"] == pytest.approx(2.0)
    assert ours["φ_l on the table by φ_l, optimum"] == pytest.approx(4.0)


@pytest.mark.slow
def test_box_is_held_and_comes_nearer() -> None:
    outcome = run(RunSettings(seed=50, quick=True))
    ours = {quantity.name: quantity.ours for quantity in outcome.quantities}
    assert ours["boxes held to the end"] == 100
    assert ours["depth, table"] > ours["depth, held"] > ours["depth, optimum"]
    assert ours["φ_l on the table by φ_l, optimum"] > ours["φ_l on the table by φ_l, held"] > 1
    (chart,) = outcome.charts
    assert chart.lines[0].y[-1] < chart.lines[0].y[0]

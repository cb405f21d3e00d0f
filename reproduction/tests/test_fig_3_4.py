"""Potentials of reaches, compared place by place."""

from __future__ import annotations

import math

import pytest

from cbdsl_reproduction.chapter_3 import fig_3_4
from cbdsl_reproduction.chapter_3.fig_3_4 import _quantities, _Reach
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict
from cbdsl_reproduction.simulation_fixture import simulation_fixture


def reach(spring: list[float], conditioning: list[float], **ending: float | bool) -> _Reach:
    return _Reach(spring, conditioning, conditioning, **{"error": 0.001, "at_rest": True, **ending})


def verdicts(c0: list[_Reach], c1: list[_Reach], c2: list[_Reach]) -> list[Verdict]:
    return [each.verdict for each in _quantities({"c0": c0, "c1": c1, "c2": c2}, 0)]


def test_reaches_as_in_the_source_are_reproduced() -> None:
    alone = [reach([1.0, 0.5, 0.0], [0.0, 1.0]) for _ in range(30)]
    below = [reach([1.0, 0.5, 0.0], [0.0, 0.5]) for _ in range(30)]
    assert set(verdicts(alone, below, below)) == {Verdict.REPRODUCED}


def test_few_reaches_of_the_same_kind_decide_nothing_of_all() -> None:
    alone = [reach([1.0, 0.5, 0.0], [0.0, 1.0]) for _ in range(5)]
    below = [reach([1.0, 0.5, 0.0], [0.0, 0.5]) for _ in range(5)]
    arrived, *_ = verdicts(alone, below, below)
    assert arrived is Verdict.UNDECIDED


def test_reaches_without_benefit_of_the_lower_controller_are_missed() -> None:
    alone = [reach([1.0, 0.5, 0.0], [0.0, 1.0]) for _ in range(30)]
    assert verdicts(alone, alone, alone)[4:] == [Verdict.MISSED] * 4


def test_reaches_that_fail_or_rise_are_reported() -> None:
    good, late = reach([1.0, 0.0], [0.0, 1.0]), reach([1.0, 0.5], [0.0, 0.1], error=0.5)
    rising = reach([1.0, 1.1, 0.0], [0.0, 0.5])
    arrived, c0, c1, c2, change, places, *_ = _quantities(
        {"c0": [good, good], "c1": [good, late], "c2": [rising, rising]}, 0
    )
    assert arrived.note.startswith("5 of 6 in 2 trials;")
    assert arrived.verdict is Verdict.UNDECIDED
    assert [each.verdict for each in (c0, c1, c2)] == [Verdict.REPRODUCED] * 2 + [Verdict.MISSED]
    # A failed reach counts with its change of the potential until the end of the attempt.
    assert (change.ours, places.note) == (pytest.approx(-0.45), "1 of 2")


def test_reaches_that_never_began_are_missed() -> None:
    none = [_Reach()] * 30
    assert set(verdicts(none, none, none)) == {Verdict.MISSED}
    assert math.isnan(
        next(
            each.ours
            for each in _quantities({"c0": none, "c1": none, "c2": none}, 0)
            if "rise of" in each.name
        )
    )
    assert fig_3_4._charts({"c0": none, "c1": none, "c2": none}, 0.1) == ()


@pytest.mark.slow
def test_two_places_on_the_simulator() -> None:
    outcome = fig_3_4.run(RunSettings(quick=True))
    assert Verdict.MISSED not in {quantity.verdict for quantity in outcome.quantities}
    assert [len(chart.lines) for chart in outcome.charts] == [3, 2, 2]


@pytest.mark.slow
def test_arm_touches_the_table_where_the_ball_lies_on_it_and_not_where_it_is_held(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    law, place = fig_3_4._LAWS["c1"], (0.32, 0.4)
    with simulation_fixture(str(fig_3_4.PROGRAM)) as lab:
        runner = lab.runner(fig_3_4._policy(lab.program.policy, law))
        above = fig_3_4._reach(lab, runner, fig_3_4._stage(lab, place), law, 1)
        monkeypatch.setattr(fig_3_4, "_HEIGHT", -0.42 + fig_3_4._RADIUS)
        lying = fig_3_4._reach(lab, runner, fig_3_4._stage(lab, place), law, 1)
    assert above.arrived and not above.touched
    assert lying.touched and not lying.arrived

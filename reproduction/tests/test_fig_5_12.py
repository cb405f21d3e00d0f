"""Comparison of a probe with two versions of TOUCH; kept episodes are not run again."""

from __future__ import annotations

from pathlib import Path

from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition
from cbdsl_reproduction.chapter_5 import fig_5_12
from cbdsl_reproduction.chapter_5.fig_5_12 import (
    PASSIVE,
    PROBING,
    SEEKING,
    quantities,
    reparameterised,
)
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict


def episodes(rewards: list[int]) -> tuple[Experience, ...]:
    def one(reward: int) -> Experience:
        step = Transition("reachtouch", 0, 1.0, "X10", "reach ◁ touch", "X11", 60, reward, ())
        return Experience("usual", 0, (step,), {}, 60, 1.0)

    return tuple(map(one, rewards))


def test_probe_is_compared_with_a_touch_that_waits_and_with_the_shipped_one() -> None:
    probing, passive, seeking = [1, 0] * 10, [0] * 20, [1] * 20
    some = {PASSIVE: passive, SEEKING: seeking, PROBING: probing}
    more, less, *rates = quantities({way: episodes(each) for way, each in some.items()}, 0)
    assert more.verdict is Verdict.REPRODUCED and more.ours == 50.0
    assert less.verdict is Verdict.MISSED and less.ours == -50.0
    assert [round(each.ours) for each in rates] == [0, 100, 50]
    even = {PASSIVE: probing, SEEKING: seeking, PROBING: probing}
    same, *_ = quantities({way: episodes(each) for way, each in even.items()}, 0)
    assert same.verdict is not Verdict.REPRODUCED
    best = {PASSIVE: passive, SEEKING: passive, PROBING: seeking}
    _, also, *_ = quantities({way: episodes(each) for way, each in best.items()}, 0)
    assert also.verdict is Verdict.REPRODUCED and "closes the fingers" in also.name


def test_only_touch_differs() -> None:
    ways = reparameterised()
    touches = {
        way: next(each for each in program.actions if each.name == "touch")
        for way, program in ways.items()
    }
    assert touches[PROBING].program is not None
    assert touches[PROBING].program.name == "tactileprobe"
    seeks = {way: each.controllers[0].seek for way, each in touches.items() if each.controllers}
    assert seeks[PASSIVE] is None and seeks[SEEKING] is not None
    assert len({str(each.policy) for each in ways.values()}) == 1


def test_experiment_resumes_from_kept_trials(tmp_path: Path) -> None:
    settings = RunSettings(seed=5430000, quick=True, folder=tmp_path, backend="kinematic")
    result = fig_5_12.run(settings)
    assert "reach" in result.charts[0].svg()
    kept = {file: file.read_text() for file in tmp_path.iterdir()}
    assert len(kept) == 3
    assert fig_5_12.run(settings).quantities == result.quantities
    assert {file: file.read_text() for file in tmp_path.iterdir()} == kept

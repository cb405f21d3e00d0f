"""Stacks that stand, judged by the state of an engine."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import pytest

from cbdsl import UsageError
from cbdsl.runtime.tick import Tick
from cbdsl_reproduction.stack_trials import StackJudge, StackTrial

ORDER = ("base", "top")
STACKED = {"base": {"table", "top"}, "top": {"base"}}
TICK = cast("Tick", None)


@dataclass
class Pose:
    position: np.ndarray[Any, np.dtype[np.float64]]


@dataclass
class Truth:
    """State of two or three objects in an engine."""

    beside: Mapping[str, Collection[str]] = field(default_factory=lambda: STACKED)
    hands: Collection[str] = ()
    speed: float = 0.0

    def touched(self, name: str) -> bool:
        return name in self.hands

    def neighbours(self, name: str) -> Collection[str]:
        return self.beside[name]

    def velocity(self, name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
        return np.array([0.0, 0.0, self.speed])

    def pose(self, name: str) -> Pose:
        return Pose(np.array([0.03 if name == "top" else 0.0, 0.04 * (name == "top"), 0.1]))


def built(after: Truth, seconds: float = 1.5, order: tuple[str, ...] = ORDER) -> StackTrial:
    """Judge a stack whose top object is lifted and released, and then in the state ``after``."""
    truth = Truth(beside={**after.beside, order[-1]: set()}, hands={order[-1]})
    judge = StackJudge(truth, order)
    judge.note(TICK)
    truth.beside, truth.hands, truth.speed = after.beside, after.hands, after.speed
    for _ in range(round(60 * seconds)):
        judge.note(TICK)
    return judge.conclude("_on_".join(reversed(order)), 7, "")


def test_object_at_rest_on_the_lower_one_stands() -> None:
    trial = built(Truth())
    assert trial.released and trial.stands
    assert trial.offset == pytest.approx(0.05)
    assert trial.pace == 0.0


@pytest.mark.parametrize(
    "after",
    [
        Truth(beside={"base": {"table"}, "top": {"table"}}),  # fell off
        Truth(beside={"base": {"table", "top"}, "top": {"base", "table"}}),  # leans
        Truth(beside={"base": {"table"}, "top": set()}),  # in the air
        Truth(speed=0.05),  # still rolls
    ],
)
def test_object_off_the_lower_one_does_not_stand(after: Truth) -> None:
    trial = built(after)
    assert trial.released and not trial.stands


def test_stack_stands_only_after_a_second() -> None:
    assert not built(Truth(), seconds=0.9).stands


def test_held_object_does_not_stand() -> None:
    trial = built(Truth(hands={"top"}))
    assert not trial.released and not trial.stands
    assert math.isnan(trial.pace) and math.isnan(trial.offset)


def test_object_that_was_not_lifted_is_not_released() -> None:
    truth = Truth()
    judge = StackJudge(truth, ORDER)
    for hands in (("top",), ()):
        truth.hands = hands
        truth.beside = {"base": {"table"}, "top": {"table"}}
        for _ in range(90):
            judge.note(TICK)
    assert not judge.conclude("top_on_base", 7, "").released


def test_stack_of_three_requires_the_middle_object_at_rest() -> None:
    order = ("base", "middle", "top")
    beside = {"base": {"table", "middle"}, "middle": {"base", "top"}, "top": {"middle"}}
    assert built(Truth(beside=beside), order=order).stands
    fallen = {"base": {"table"}, "middle": {"table", "top"}, "top": {"middle"}}
    assert not built(Truth(beside=fallen), order=order).stands


def test_judge_of_stacks_rejects_an_engine_without_contacts() -> None:
    with pytest.raises(UsageError, match="use --backend bullet or mujoco"):
        StackJudge(object(), ("ball", "box"))

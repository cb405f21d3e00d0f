"""The reward rule (Eq 4.2 to 4.4) where it is applied: letters and errors in, rewards out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import resources_of
from cbdsl.program.transition import Transition
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.policies.policy import Choice, Policy
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from tests.conftest import Checked

BOTH = "search ◁ track"
NEAR, FAR = 0.0, 1.0
"""Errors within and out of the 5 degrees in which a heading earns its reward, rad."""

Step = Callable[[str, float], Transition | None]


class Always(Policy):
    """Policy that chooses one action in every state."""

    def choose(self, state: str, *, changed: bool, features: object = None) -> Choice:
        return Choice(BOTH)


@pytest.fixture
def step(checked: Checked, dexter: RobotDocument, kinematics: Kinematics) -> Step:
    """Return a function by which a running SEARCH ◁ TRACK reads a state, given its errors."""
    program = checked("searchtrack")
    signals, plan = Signals(dexter, kinematics, resources_of(program)), ControllerPlan()
    signals.reset()
    still = np.zeros(len(signals.joints.names))
    loads = {
        (hand, cell): np.zeros(6) for hand in dexter.load_cells for cell in dexter.load_cells[hand]
    }
    signals.update(Observation(0.0, still, still, loads, {}))
    run = ProgramRun(program, signals, plan, 1 / 60)
    transitions: list[Transition] = []
    run.begin(np.random.default_rng(0), transitions.append, Always())
    run.activate()
    by_name: dict[str, ControllerRun] = {each.controller.name: each for each in run.runs}

    def advance(state: str, error: float) -> Transition | None:
        transitions.clear()
        for name, letter in zip(("search", "track"), state, strict=True):
            by_name[name].predicate = letter
            plan.slots["error"][by_name[name].slot] = error
        run.advance()
        return transitions[0] if transitions else None

    return advance


def rewards(transition: Transition | None) -> tuple[str, ...]:
    assert transition is not None
    assert transition.reward == len(transition.rewarding)
    return transition.rewarding


def test_newly_at_rest_on_a_reached_reference_is_rewarded(step: Step) -> None:
    step("00", NEAR)
    assert rewards(step("01", NEAR)) == ("track",)


def test_rest_far_from_the_reference_is_not_rewarded(step: Step) -> None:
    step("00", FAR)
    assert rewards(step("01", FAR)) == ()


def test_controller_at_rest_before_is_not_rewarded_again(step: Step) -> None:
    """Though the state changes, by another letter, and the error is within the tolerance now."""
    step("00", FAR)
    step("01", FAR)
    assert rewards(step("-1", NEAR)) == ()
    assert rewards(step("-0", NEAR)) == ()
    assert rewards(step("-1", NEAR)) == ("track",)


def test_undefined_error_is_not_rewarded(step: Step) -> None:
    step("00", FAR)
    assert rewards(step("01", np.nan)) == ()


def test_controller_without_a_signal_of_the_environment_is_not_rewarded(step: Step) -> None:
    step("00", NEAR)
    assert rewards(step("10", NEAR)) == ()


def test_unchanged_state_is_no_event(step: Step) -> None:
    step("00", NEAR)
    assert step("00", NEAR) is None

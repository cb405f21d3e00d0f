"""An action that changes nothing loses its value, and one on the way keeps it."""

from __future__ import annotations

from cbdsl.learning.accommodate import Accommodate
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.program.transition import Transition
from cbdsl_reproduction.learners.decisive import Decisive

ACTIONS = ("reach", "touch")


def step(state: str, action: str, after: str, reward: int = 0) -> Transition:
    return Transition("some", 0, 0.0, state, action, after, 1, reward)


def value_after(learner: Accommodate, *steps: Transition) -> float:
    learner.see(step("X0", "touch", "X1", reward=1))
    for each in steps:
        learner.see(each)
    return learner.values.value("X0", "touch")


def test_transition_without_change_has_no_value() -> None:
    vain = [step("X0", "touch", "X0")] * 20
    plain = value_after(Accommodate(ACTIONS, AccommodateConstants()), *vain)
    decisive = value_after(Decisive(ACTIONS, AccommodateConstants()), *vain)
    assert decisive < 0.2 * plain


def test_transition_to_another_state_has_the_discounted_value_of_that_state() -> None:
    learner = Decisive(ACTIONS, AccommodateConstants())
    value_after(learner, step("XX", "reach", "X0"))
    assert learner.values.value("XX", "reach") > 0

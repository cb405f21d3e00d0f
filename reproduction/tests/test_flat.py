"""The flat learner: a state ends with letters of the context that was seen in it."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.checking.program import check_program
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Choice, Policy
from cbdsl.yaml_text.library import Library
from cbdsl_reproduction.learners.flat import Flat, FlatPolicy
from cbdsl_reproduction.learners.handedness_learner import replay
from tests.conftest import ROOT

LEFT = {"velocity.y": 0.0, "place.y": 0.4, "volume": 0.001}
RIGHT = {**LEFT, "place.y": -0.4}
FIRST, SECOND = "reach ◁ touch", "touch ◁ reach"


@pytest.fixture(scope="module")
def program() -> CheckedProgram:
    return check_program("reachtouch", {}, Library(ROOT))


@pytest.fixture
def learner(program: CheckedProgram) -> Flat:
    return Flat(program, AccommodateConstants())


def step(state: str, action: str, after: str, features: dict[str, float]) -> Transition:
    reward = int(after == "X11")
    return Transition("reachtouch", 0, 0.0, state, action, after, 1, reward, (), "", features)


def episode(*steps: Transition) -> Experience:
    return Experience("some", 0, steps, {}, 1, 0.1)


def test_next_state_belongs_to_the_context_seen_at_the_transition(learner: Flat) -> None:
    last = step("X0-", SECOND, "X11", RIGHT)
    replay(learner, episode(step("XX-", FIRST, "X0-", LEFT), last))
    counts = dict(learner.accommodate.counts.items())
    assert counts == {
        "XX-sls": {FIRST: {"X0-srs": 1}},
        "X0-srs": {SECOND: {"X11srs": 1}},
    }


def test_equal_letters_in_another_context_are_another_state(learner: Flat) -> None:
    for _ in range(10):
        replay(learner, episode(step("XX-", FIRST, "X11", LEFT)))
        replay(learner, episode(step("XX-", SECOND, "X11", RIGHT)))
        replay(learner, episode(step("XX-", FIRST, "X1-", RIGHT)))
    greedy = learner.accommodate.greedy()
    assert (greedy["XX-sls"], greedy["XX-srs"]) == (FIRST, SECOND)


def test_transitions_of_an_unfinished_episode_are_discarded(learner: Flat) -> None:
    learner.begin()
    learner.see(step("XX-", FIRST, "X0-", LEFT))
    replay(learner, episode(step("XX-", SECOND, "X1-", RIGHT)))
    assert set(dict(learner.accommodate.counts.items())) == {"XX-srs"}
    learner.begin()
    learner.remember(episode())  # nothing was done, and nothing is taken in
    assert set(dict(learner.accommodate.counts.items())) == {"XX-srs"}


def test_policy_reads_the_context_at_each_choice(learner: Flat, program: CheckedProgram) -> None:
    asked = []

    class Asked(Policy):
        def choose(self, state: str, *, changed: bool, features: object = None) -> Choice:
            asked.append((state, changed))
            return Choice(FIRST)

    policy = FlatPolicy(Asked())
    assert policy.choose("XX-", changed=True) == Choice(FIRST)  # where nothing can be read
    policy.choose("XX-", changed=False, features=LEFT)
    policy.choose("XX-", changed=True, features=LEFT | {"place.y": -0.4})
    assert asked == [("XX-???", True), ("XX-sls", False), ("XX-srs", True)]
    learner.begin()
    planned = learner.plan(np.random.default_rng(0))
    assert planned.program is program and not learner.is_constrained
    names = {action.name for action in program.actions}
    assert planned.policy.choose("XX-", changed=True).action in names

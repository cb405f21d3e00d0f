"""Stages of the staged learner: one arm and exploring, then all, and values that still change."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.api.shipped import shipped_file
from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.learning.assimilate import AssimilateConstants
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition
from cbdsl.yaml_text.library import Library, shipped
from cbdsl_reproduction.learners.handedness_learner import replay
from cbdsl_reproduction.learners.staged import Staged

LEADING, OTHER = "touch ◁ reach", "reach ◁ touch"


@pytest.fixture
def learner() -> Staged:
    library = Library(shipped())
    path = shipped_file(library, ProgramDocument, "reachtouch")
    policy = library.read(shipped_file(library, PolicyDocument, "reachtouch"), PolicyDocument)
    schema = program_to_assimilate(path, policy, Session(library), {})
    own = check_program(path, {}, library)
    return Staged(schema, own, AccommodateConstants(), AssimilateConstants(), episodes=2)


def episode(state: str, action: str, after: str, reward: int, allocation: str = "") -> Experience:
    name = f"{action} with {allocation}" if allocation else action
    only = Transition("reachtouch", 0, 0.0, state, name, after, 1, reward, (), allocation)
    return Experience("right", 0, (only,), {}, 1, 0.1)


def test_first_stage_is_the_own_arm(learner: Staged) -> None:
    rng = np.random.default_rng(0)
    for _ in range(2):
        assert learner.is_constrained
        learner.begin()
        assert learner.plan(rng).program.schema is None
        replay(learner, episode("X0-", LEADING, "X11", 1))
    assert not learner.is_constrained
    learner.begin()
    assert learner.plan(rng).program.schema is not None


def test_choice_that_fails_with_other_arms_is_given_up(learner: Staged) -> None:
    for _ in range(2):
        replay(learner, episode("X0-", LEADING, "X11", 1))
    assert learner.accommodate.greedy()["X0-"] == LEADING
    replay(learner, episode("X0-", OTHER, "X11", 1, "left_arm"))
    for _ in range(8):
        replay(learner, episode("X0-", LEADING, "X0-", 0, "left_arm"))
    assert learner.accommodate.greedy()["X0-"] == OTHER

"""Contract of learners: declared constants, and knowledge that follows from experience alone."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.json_schema import properties
from cbdsl.learning.constants import read_constants
from cbdsl.learning.experience import Experience
from cbdsl.learning.learner import LEARNERS, Learner, LearnerClass, first_line, replay
from cbdsl.program.transition import Transition

ACTIONS = ("search", "track")
CLASSES = LEARNERS.all()
LEARNER = pytest.mark.parametrize("learner", CLASSES.values(), ids=CLASSES)


def _episode(rng: np.random.Generator) -> Experience:
    """Return an episode of a program of two members; the last transition may be rewarded."""
    count = int(rng.integers(1, 6))
    states = ["".join(rng.choice([*"X-01"], 2)) for _ in range(count + 1)]
    rewarded = bool(rng.integers(2))
    transitions = tuple(
        Transition(
            "p", 0, 0.1 * i, states[i], str(rng.choice(ACTIONS)), states[i + 1], 6,
            int(rewarded and i == count - 1),
        )
        for i in range(count)
    )  # fmt: skip
    references = {"head": (float(rng.uniform(-1, 1)), 0.5)} if rewarded else {}
    return Experience("here", 1, transitions, references, 6 * count, 0.1 * count)


def _fresh(learner: LearnerClass) -> Learner:
    return learner(ACTIONS, learner.Constants(), {})


def _knowledge(learner: Learner) -> object:
    policy = learner.policy(np.random.default_rng(3))
    states = [a + b for a in "X-01" for b in "X-01"]
    chosen = [policy.choose(state, changed=True).action for state in states for _ in range(5)]
    return learner.greedy(), learner.densities(), chosen


@LEARNER
def test_constants_are_declared_with_meanings_and_defaults(learner: LearnerClass) -> None:
    assert first_line(learner).endswith(".")
    for name, value in properties(learner.Constants).items():
        assert len(value["description"]) > 5, name
    constants = learner.Constants()
    assert pickle.loads(pickle.dumps(constants)) == constants
    text = {name: str(value) for name, value in constants.model_dump(exclude_none=True).items()}
    assert read_constants(learner.Constants, text, "it") == constants


@LEARNER
def test_wrong_constants_are_named(learner: LearnerClass) -> None:
    for name in learner.Constants.model_fields:
        for text in ("nan", "inf", "-1", "some words", "3 furlongs"):
            with pytest.raises(UsageError, match=f"constant {name} = {text}: "):
                read_constants(learner.Constants, {name: text}, "it")
        with pytest.raises(UsageError, match=f"did you mean '{name}'"):
            read_constants(learner.Constants, {f"{name}s": "1"}, "it")


@LEARNER
@pytest.mark.parametrize("seed", range(30))
def test_equal_experience_is_equal_knowledge(learner: LearnerClass, seed: int) -> None:
    rng = np.random.default_rng(seed)
    experiences = [_episode(rng) for _ in range(seed % 6)]
    one, other = _fresh(learner), _fresh(learner)
    for taught in (one, other):
        for experience in experiences:
            replay(taught, experience)
    assert _knowledge(pickle.loads(pickle.dumps(one))) == _knowledge(one) == _knowledge(other)
    assert set(one.greedy().values()) <= set(ACTIONS)
    chosen = one.policy(np.random.default_rng(0)).choose("XX", changed=False).action
    assert chosen in ACTIONS

"""All registered learners: declared constants, and knowledge that follows from experience alone."""

from __future__ import annotations

import pickle
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import Section
from cbdsl.documents.json_schema import properties
from cbdsl.learning.constants import read_constants
from cbdsl.learning.experience import Experience
from cbdsl.learning.learner import LEARNERS, Learner, LearnerClass, first_line, replay
from cbdsl.program.transition import Transition
from cbdsl.types.registry import PluginError, Registry

ACTIONS = ("search", "track")
METHODS = ("see", "remember", "policy", "greedy", "densities", "documents")
CLASSES = LEARNERS.all()
LEARNER = pytest.mark.parametrize("learner", CLASSES.values(), ids=CLASSES)


@st.composite
def episodes(draw: st.DrawFn) -> Experience:
    """Return episodes of a program of two members; the last transition may be rewarded."""
    states = draw(st.lists(st.text("X-01", min_size=2, max_size=2), min_size=2, max_size=6))
    actions = [draw(st.sampled_from(ACTIONS)) for _ in states[1:]]
    rewarded = draw(st.booleans())
    count = len(actions)
    transitions = tuple(
        Transition("p", 0, 0.1 * i, states[i], actions[i], states[i + 1], 6, reward)
        for i, reward in enumerate([0] * (count - 1) + [int(rewarded)])
    )
    found = {"head": (draw(st.floats(-1, 1)), 0.5)} if rewarded else {}
    return Experience("here", 1, transitions, found, 6 * count, 0.1 * count)


def _fresh(learner: LearnerClass) -> Learner:
    return learner(ACTIONS, learner.Constants(), {})


def _knowledge(learner: Learner) -> object:
    rng = np.random.default_rng(3)
    policy = learner.policy(rng)
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
@given(st.lists(episodes(), max_size=5))
def test_equal_experience_is_equal_knowledge(
    learner: LearnerClass, experiences: list[Experience]
) -> None:
    one, other = _fresh(learner), _fresh(learner)
    for experience in experiences:
        replay(one, experience)
    for experience in experiences:
        replay(other, experience)
    assert _knowledge(one) == _knowledge(other)
    assert set(one.greedy().values()) <= set(ACTIONS)
    chosen = one.policy(np.random.default_rng(0)).choose("XX", changed=False).action
    assert chosen in ACTIONS


class Needy(Section):
    """Constants of which one has no default."""

    alpha: float


def offered(monkeypatch: pytest.MonkeyPatch, **without: object) -> Any:
    """Return a registered class with all members of a learner, except for some."""
    whole = {**dict.fromkeys(METHODS, lambda: None), "Constants": Section, **without}
    monkeypatch.setattr(sys.modules[__name__], "Offered", type("Offered", (), whole))
    registry: Any = Registry("learner", "none", {"it": f"{__name__}:Offered"}, LEARNERS._validate)
    return registry.get("it")


Offered: Any = None


@pytest.mark.parametrize("lacking", [*METHODS, "Constants"])
def test_a_class_that_lacks_something_is_no_learner(
    lacking: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert offered(monkeypatch) is Offered
    with pytest.raises(PluginError, match=lacking):
        offered(monkeypatch, **{lacking: None})


def test_constants_of_a_learner_have_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(PluginError, match="no default: alpha"):
        offered(monkeypatch, Constants=Needy)

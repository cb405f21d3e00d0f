"""Q-learning finds the values of Markov decision processes that are solved another way."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.learning.accommodate import QLearning
from cbdsl.numeric.arrays import Floats

GAMMA = 0.8


class Process(NamedTuple):
    """States and actions by number; ``after`` has shape (s, a, s), ``reward`` (s, a).

    A rewarded transition ends the episode.
    """

    after: Floats
    reward: Floats

    def solve(self) -> Floats:
        """Return the values by value iteration, shape (s, a)."""
        values = np.zeros_like(self.reward)
        goes_on = self.reward == 0
        for _ in range(200):
            values = self.reward + GAMMA * goes_on * (self.after @ values.max(axis=1))
        return values


def process(rng: np.random.Generator, states: int, actions: int, *, certain: bool) -> Process:
    after = rng.dirichlet(np.full(states, 0.5), size=(states, actions))
    if certain:
        after = np.eye(states)[after.argmax(axis=2)]
    return Process(after, (rng.random((states, actions)) < 0.3) * rng.integers(1, 3, size=1))


def learn(process: Process, alpha: float, sweeps: int, rng: np.random.Generator) -> Floats:
    states, actions = process.reward.shape
    learner = QLearning([str(a) for a in range(actions)], GAMMA, alpha)
    bounds = process.after.cumsum(axis=2)
    for _ in range(sweeps):
        for state, action in np.ndindex(states, actions):
            after = min(int(np.searchsorted(bounds[state, action], rng.random())), states - 1)
            reward = float(process.reward[state, action])
            learner.update(str(state), str(action), reward, str(after), ended=reward > 0)
    return np.array(
        [[learner.value(str(s), str(a)) for a in range(actions)] for s in range(states)]
    )


SIZES = {"seed": st.integers(0, 2**32), "states": st.integers(1, 5), "actions": st.integers(1, 4)}


@settings(deadline=None, max_examples=30)
@given(**SIZES)
def test_values_of_a_deterministic_process_are_exact(seed: int, states: int, actions: int) -> None:
    rng = np.random.default_rng(seed)
    made = process(rng, states, actions, certain=True)
    assert learn(made, 0.5, 200, rng) == pytest.approx(made.solve(), abs=1e-6)


@settings(deadline=None, max_examples=6)
@given(**SIZES)
def test_values_of_a_random_process_are_approximated(seed: int, states: int, actions: int) -> None:
    rng = np.random.default_rng(seed)
    made = process(rng, states, actions, certain=False)
    assert learn(made, 0.02, 1500, rng) == pytest.approx(made.solve(), abs=0.2)


def test_update_follows_line_16_of_algorithm_1() -> None:
    learner = QLearning(["a", "b"], gamma=0.8, alpha=0.1)
    learner.update("1", "b", 1.0, "end", ended=True)
    assert learner.value("1", "b") == pytest.approx(0.1)
    learner.update("0", "a", 0.0, "1", ended=False)
    assert learner.value("0", "a") == pytest.approx(0.1 * 0.8 * 0.1)
    assert learner.value("0", "b") == 0.0


def test_ended_transition_has_no_continuation() -> None:
    learner = QLearning(["a"], gamma=0.8, alpha=1.0)
    learner.update("1", "a", 1.0, "end", ended=True)
    learner.update("0", "a", 0.0, "1", ended=True)
    assert learner.value("0", "a") == 0.0


def test_unknown_state_has_value_zero_and_all_actions_best() -> None:
    learner = QLearning(["a", "b", "c"], gamma=0.8, alpha=0.1)
    assert learner.best("never seen") == ("a", "b", "c")
    learner.update("0", "b", 1.0, "1", ended=True)
    assert learner.best("0") == ("b",)
    assert dict(learner.items()) == {"0": {"b": 0.1}}

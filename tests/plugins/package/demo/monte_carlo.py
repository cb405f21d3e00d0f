"""Monte Carlo control: the value of an action is the mean of the returns that followed."""

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

from cbdsl.extend.learner import (
    NO_FEATURES,
    Choice,
    Document,
    Experience,
    Features,
    Policy,
    Section,
    Transition,
    TrialSummary,
    policy_document,
    quantity,
)

Means = dict[str, dict[str, float]]


class MonteCarloConstants(Section):
    """Constants of Monte Carlo control."""

    gamma: Annotated[float, quantity(ge=0, le=1)] = 0.9
    """Discount of later rewards."""
    exploration: Annotated[float, quantity(ge=0, le=1)] = 0.1
    """Share of actions chosen at random."""
    patience: Annotated[float, quantity("time", gt=0)] = 60.0
    """Simulated time after which an episode is ignored, s."""


class MonteCarlo:
    """Monte Carlo control with every visit and epsilon-greedy exploration."""

    Constants = MonteCarloConstants

    def __init__(
        self, actions: Sequence[str], constants: MonteCarloConstants, programs: Mapping[int, str]
    ) -> None:
        self._actions, self._constants = tuple(actions), constants
        self._returns: dict[tuple[str, str], list[float]] = {}

    def see(self, transition: Transition) -> None:
        """Wait for the end of the episode."""

    def remember(self, experience: Experience) -> None:
        """Record the returns of an episode, from its last transition to its first."""
        if experience.sim_seconds > self._constants.patience:
            return
        following = 0.0
        for transition in reversed(experience.transitions):
            following = transition.reward + self._constants.gamma * following
            visited = transition.state, transition.action
            self._returns.setdefault(visited, []).append(following)

    def policy(self, rng: np.random.Generator) -> "EpsilonGreedy":
        """Return the best known action, or sometimes a random one."""
        return EpsilonGreedy(self.greedy(), self._actions, self._constants.exploration, rng)

    def greedy(self) -> dict[str, str]:
        """Return the action of the largest mean return, by state."""
        means = self._means()
        return {state: max(means[state], key=means[state].__getitem__) for state in means}

    def densities(self) -> dict[str, object]:
        """Return no internal models."""
        return {}

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Return the greedy policy with its mean returns."""
        values = {
            state: {action: round(mean, 6) for action, mean in means.items()}
            for state, means in self._means().items()
        }
        return [policy_document(summary, self.greedy(), values=values)]

    def _means(self) -> Means:
        found: Means = {}
        for (state, action), returns in self._returns.items():
            found.setdefault(state, {})[action] = float(np.mean(returns))
        return found


class EpsilonGreedy(Policy):
    """Policy that explores."""

    def __init__(
        self,
        best: Mapping[str, str],
        actions: Sequence[str],
        exploration: float,
        rng: np.random.Generator,
    ) -> None:
        self._best, self._actions, self._exploration, self._rng = best, actions, exploration, rng

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Return the best known action of a state, or a random one."""
        if state not in self._best or self._rng.random() < self._exploration:
            return Choice(self._actions[int(self._rng.integers(len(self._actions)))])
        return Choice(self._best[state])

"""ACCOMMODATE: action values and internal models from affordance discovery (Algorithm 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.learning.epsilon_greedy import choose
from cbdsl.learning.experience import Experience
from cbdsl.learning.prior import Form, learned_density
from cbdsl.learning.q_learning import QLearning
from cbdsl.learning.transition_counts import TransitionCounts
from cbdsl.program.transition import Transition


@dataclass(frozen=True)
class Constants:
    """Constants of Algorithm 1, line 3, and of the densities that it learns.

    Attributes:
        gamma: discount.
        alpha: learning rate.
        epsilon: share of the actions that are chosen at random.
        density: form of the internal models.
        bandwidth: standard deviation of their kernels, smallest one of their Gaussians, rad.
        prior: as how many samples the uniform density counts that they start as.
    """

    gamma: float = 0.8
    alpha: float = 0.1
    epsilon: float = 0.2
    density: Form = "kernel"
    bandwidth: float = 0.1
    prior: float = 10.0


class Accommodate:
    """What one trial has learned so far. Chance comes from the caller.

    Equal experience in equal order leaves equal knowledge, to the last bit.

    Attributes:
        values: Phi of Algorithm 1.
        counts: the transitions that were observed.
    """

    def __init__(self, actions: Sequence[str], constants: Constants) -> None:
        self._constants = constants
        self.values = QLearning(actions, constants.gamma, constants.alpha)
        self.counts = TransitionCounts()
        self._samples: dict[str, list[tuple[float, ...]]] = {}

    def see(self, transition: Transition) -> None:
        """Take in one transition; a rewarded one ends its episode (line 7)."""
        state, action, after = transition.state, transition.action, transition.next_state
        ended = transition.reward > 0
        self.values.update(state, action, transition.reward, after, ended=ended)
        self.counts.add(state, action, after)

    def remember(self, experience: Experience) -> None:
        """Take in what a finished episode found rewarded (line 19), besides its transitions."""
        for effector, configuration in experience.rewarded.items():
            self._samples.setdefault(effector, []).append(configuration)

    def replay(self, experience: Experience) -> None:
        """Take in an episode that was finished before."""
        for transition in experience.transitions:
            self.see(transition)
        self.remember(experience)

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """By effector, where it was when a controller that moves it was rewarded."""
        constants = self._constants
        return {
            effector: learned_density(
                samples, constants.density, constants.bandwidth, constants.prior
            )
            for effector, samples in self._samples.items()
        }

    def explorer(self, rng: np.random.Generator) -> Explorer:
        """Chooses the actions of an episode by what is known then."""
        return Explorer(self.values, self._constants.epsilon, rng)

    def greedy(self) -> dict[str, str]:
        """The best action of every state in which one was tried.

        Of equally good ones it is the first in the order of the program's actions.
        """
        return {state: self.values.best(state)[0] for state, _ in self.values.items()}


class Explorer:
    """The policy of a learner: epsilon-greedy, in every state, known or not."""

    def __init__(self, values: QLearning, epsilon: float, rng: np.random.Generator) -> None:
        self._values, self._epsilon, self._rng = values, epsilon, rng

    def choose(self, state: str, *, changed: bool) -> str:
        """The next action; after one that changed nothing, too."""
        return choose(self._values.best(state), self._values.actions, self._epsilon, self._rng)

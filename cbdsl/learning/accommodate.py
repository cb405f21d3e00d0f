"""ACCOMMODATE: action values and internal models from affordance discovery (Algorithm 1)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from cbdsl.documents.document import Document
from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.learning.constants import AccommodateConstants, DensityConstants, Form
from cbdsl.learning.decisions import Decisions
from cbdsl.learning.experience import Experience
from cbdsl.learning.knowledge_documents import model_documents, policy_document
from cbdsl.learning.learner import TrialSummary
from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Choice, Policy
from cbdsl.types.state import ANY


class RewardedConfigurations:
    """Rewarded configurations of effectors, and their densities (line 19).

    Args:
        constants: Constants of the densities.
    """

    def __init__(self, constants: DensityConstants) -> None:
        self._constants = constants
        self._samples: dict[str, list[tuple[float, ...]]] = {}

    def add(self, experience: Experience) -> None:
        """Add the rewarded configurations of an episode."""
        for effector, configuration in experience.rewarded.items():
            self._samples.setdefault(effector, []).append(configuration)

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Return densities of the rewarded configurations, by effector."""
        constants = self._constants
        return {
            effector: learned_density(
                samples, constants.density, constants.bandwidth, constants.prior
            )
            for effector, samples in self._samples.items()
        }


class TransitionCounts:
    """Observed transitions, by state, action and next state."""

    def __init__(self) -> None:
        self._counts: dict[str, dict[str, dict[str, int]]] = {}

    def add(self, state: str, action: str, next_state: str) -> None:
        """Count one transition."""
        after = self._counts.setdefault(state, {}).setdefault(action, {})
        after[next_state] = after.get(next_state, 0) + 1

    def items(self) -> Iterator[tuple[str, dict[str, dict[str, int]]]]:
        """Yield counts by action and next state, by state, in the order of first occurrence."""
        for state, actions in self._counts.items():
            yield state, {action: dict(after) for action, after in actions.items()}


def learned_density(
    samples: Sequence[Sequence[float]], form: Form, bandwidth: float, prior: float
) -> Kernel | Gaussian:
    """Return the density of rewarded configurations, mixed with the initial uniform density.

    Configurations without reward stay possible, and become less likely with more samples
    (Section 4.2).

    Args:
        samples: Configurations, rad, shape (n, joints), n >= 1.
        form: ``kernel`` for a Gaussian around each configuration, ``gaussian`` for one per joint.
        bandwidth: Standard deviation of the kernels, smallest one of a Gaussian, rad.
        prior: Weight of the uniform density, in samples.
    """
    # Model: with n samples tau_i, bandwidth b and prior weight p,
    #     Pr(tau | sigma, reward) = u U(tau) + (1 - u) / n sum_i N(tau; tau_i, b^2),
    # where U is the uniform density over the joint ranges, and u = p / (p + n) its share.
    uniform = prior / (prior + len(samples))
    angles = np.array(samples, dtype=float)
    joints = angles.shape[1]
    if form == "kernel":
        rows = tuple(_rounded(row) for row in angles)
        return Kernel(form="kernel", samples=rows, bandwidth=(bandwidth,) * joints, uniform=uniform)
    # A single sample has a deviation of 0.
    deviation = np.maximum(angles.std(axis=0), bandwidth)
    mean = _rounded(angles.mean(axis=0))
    return Gaussian(form="gaussian", mean=mean, deviation=_rounded(deviation), uniform=uniform)


def _rounded(angles: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    """Round to microradians, so that written and sampled densities agree."""
    return tuple(round(float(angle), 6) for angle in angles)


def choose(
    best: Sequence[str], actions: Sequence[str], epsilon: float, rng: np.random.Generator
) -> str:
    """Return a uniform choice among the best actions, or with probability ``epsilon`` among all.

    Algorithm 1, line 9.

    Args:
        best: Actions of the largest value.
        actions: All actions, including the best ones.
        epsilon: Probability of exploration, in [0, 1].
        rng: Random generator.
    """
    among = actions if rng.random() < epsilon else best
    return among[int(rng.integers(len(among)))]


# Decimals of learned values; further ones are not significant.
_DECIMALS = 6


# Model (Algorithm 1, Section 4.2): Q-learning over states of predicates,
#     Phi(s, a) <- Phi(s, a) + alpha (r + gamma max_a' Phi(s', a') - Phi(s, a)),
# with epsilon-greedy exploration and initial values of 0. A reward ends its episode, so that the
# value of the state after it is 0. Rewarded configurations are samples of Pr(tau | sigma, reward),
# from which controllers draw their references. Assumption: the predicates suffice to predict the
# next state. Other conditions, such as the place of an object, appear as chance.
class Accommodate:
    """Q-learning with epsilon-greedy exploration, and densities of rewarded configurations.

    The same experience in the same order leads to bitwise identical knowledge.

    The intermediate states of a program among the actions have no value of their own: see
    ``Decisions``.

    Args:
        actions: Names of the actions.
        constants: Constants of the algorithm.
        programs: Actions that are programs, by the place of their predicates in a state.

    Attributes:
        values: Action values Phi of Algorithm 1.
        counts: Counts of the observed transitions.
    """

    Constants = AccommodateConstants

    def __init__(
        self,
        actions: Sequence[str],
        constants: AccommodateConstants,
        programs: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        self._constants = constants
        self._decisions = Decisions(programs)
        self.values = QLearning(actions, constants.gamma, constants.alpha)
        self.counts = TransitionCounts()
        self._rewarded = RewardedConfigurations(constants)
        self._episodes = 0

    def see(self, transition: Transition) -> None:
        """Learn from one transition; a rewarded one ends its episode (line 7)."""
        self.counts.add(transition.state, transition.action, transition.next_state)
        over = self._decisions.over(transition)
        if over is not None:
            ended = self.ends(over)
            self.values.update(over.state, over.action, over.reward, over.next_state, ended=ended)

    def ends(self, decision: Transition) -> bool:
        """Return whether the state after a decision has no value."""
        return decision.reward > 0

    def remember(self, experience: Experience) -> None:
        """Learn from the rewarded configurations of a finished episode (line 19)."""
        self._episodes += 1
        self._rewarded.add(experience)

    def densities(self) -> dict[str, Kernel | Gaussian]:
        """Return densities of the rewarded configurations, by effector."""
        return self._rewarded.densities()

    def policy(self, rng: np.random.Generator) -> Explorer:
        """Return the epsilon-greedy policy of the next episode, from the present knowledge."""
        exploring = self._constants.exploring_episodes
        explores = exploring is None or self._episodes < exploring
        epsilon = self._constants.epsilon if explores else 0.0
        return Explorer(self.values, epsilon, rng, self._decisions.running)

    def greedy(self) -> dict[str, str]:
        """Return the best action of every visited state, and one default for all other states.

        Among equally good actions, the first in the order of the program's actions is chosen. All
        actions are equally good in a state that was never visited. While a program runs, it is
        chosen.
        """
        known = {
            state: self._decisions.running(state) or self.values.best(state)[0]
            for state, _ in self.counts.items()
        }
        return known | {ANY * len(state): self.values.actions[0] for state in known}

    def documents(self, summary: TrialSummary) -> list[Document]:
        """Return the internal models, and the greedy policy with its values and transitions."""
        values = {
            state: {action: round(value, _DECIMALS) for action, value in values.items()}
            for state, values in self.values.items()
        }
        policy = policy_document(
            summary, self.greedy(), values=values, transitions=dict(self.counts.items())
        )
        return [*model_documents(summary, self.densities()), policy]


class Explorer(Policy):
    """Epsilon-greedy policy for visited and unvisited states.

    Args:
        values: Learned action values.
        epsilon: Share of the actions that are chosen at random.
        rng: Random generator of the choices.
        running: Function from a state to the program that runs in it and cannot be left, or
            ``None``.
    """

    def __init__(
        self,
        values: QLearning,
        epsilon: float,
        rng: np.random.Generator,
        running: Callable[[str], str | None],
    ) -> None:
        self._values, self._epsilon, self._rng = values, epsilon, rng
        self._running = running

    def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
        """Return the next action, also after an action that changed nothing."""
        # A running program cannot be left, so that its continuation draws no random number.
        action = self._running(state) or choose(
            self._values.best(state), self._values.actions, self._epsilon, self._rng
        )
        return Choice(action)


class QLearning:
    """Action values with zero as initial value.

    Args:
        actions: Actions of every state.
        gamma: Discount factor, in [0, 1).
        alpha: Learning rate, in (0, 1].
    """

    def __init__(self, actions: Sequence[str], gamma: float, alpha: float) -> None:
        self.actions = tuple(actions)
        self._gamma, self._alpha = gamma, alpha
        self._values: dict[str, dict[str, float]] = {}

    def value(self, state: str, action: str) -> float:
        """Return the expected discounted reward of an action in a state, zero if unknown."""
        return self._values.get(state, {}).get(action, 0.0)

    def best(self, state: str) -> tuple[str, ...]:
        """Return the actions of the largest value, several if they are equal."""
        values = [self.value(state, action) for action in self.actions]
        most = max(values)
        # All values are 0 at first. A choice of the first maximum would always begin with the same
        # action.
        return tuple(a for a, value in zip(self.actions, values, strict=True) if value == most)

    def update(
        self, state: str, action: str, reward: float, next_state: str, *, ended: bool
    ) -> None:
        """Learn from one transition.

        Args:
            state: State before the action.
            action: Action that was taken.
            reward: Reward of the action.
            next_state: State after the action.
            ended: True if nothing can follow, so that the next state has no value.
        """
        value = self.value(state, action)
        target = reward if ended else reward + self._gamma * self._most(next_state)
        self._values.setdefault(state, {})[action] = value + self._alpha * (target - value)

    def items(self) -> Iterator[tuple[str, dict[str, float]]]:
        """Yield the values of the tried actions by state, in the order of first trial."""
        for state, values in self._values.items():
            yield state, {action: values[action] for action in self.actions if action in values}

    def _most(self, state: str) -> float:
        return max(self.value(state, action) for action in self.actions)

"""Tabular Q-learning (Algorithm 1, line 16)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence


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

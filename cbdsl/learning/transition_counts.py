"""Counts of observed transitions."""

from __future__ import annotations

from collections.abc import Iterator


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

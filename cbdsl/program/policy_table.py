"""Table of a policy: actions by state pattern."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.types.state import closest_first, matches


class PolicyTable:
    """Table of state patterns; the matching pattern with the fewest wildcards applies.

    Args:
        table: Action by state pattern.
    """

    def __init__(self, table: Mapping[str, str]) -> None:
        self._table = {pattern: table[pattern] for pattern in closest_first(table)}
        #: Actions of the states of previous look-ups.
        self._known: dict[str, str | None] = {}

    def find(self, state: str) -> str | None:
        """Return the action of a state, or ``None`` if no pattern matches."""
        if state not in self._known:
            patterns = (pattern for pattern in self._table if matches(pattern, state))
            first = next(patterns, None)
            self._known[state] = None if first is None else self._table[first]
        return self._known[state]

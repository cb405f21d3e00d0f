"""Arcs of transition diagrams: successions of states under a policy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.api.drawing import ABOVE
from cbdsl.api.learning import Experience
from cbdsl.api.program import SUBJECT_TO, matches


class ActionArc(NamedTuple):
    """State, action, and next state."""

    state: str
    action: str
    next_state: str


@dataclass(frozen=True)
class DrawnArc:
    """Arc that the source draws, or alternative arcs of which one suffices.

    Attributes:
        state: Pattern of the state that it leaves.
        action: Action in that state.
        next_states: Patterns of the state to which it leads.
        context: Context of the stage to which the search is limited; ``None`` for all contexts.
    """

    state: str
    action: str
    next_states: tuple[str, ...]
    context: str | None = None

    def __str__(self) -> str:
        where = f" ({self.context})" if self.context else ""
        return f"{self.state}, {self.action} → {' or '.join(self.next_states)}{where}"

    def is_among(self, arcs: Iterable[ActionArc]) -> bool:
        """Return whether a diagram has the arc."""
        return any(arc.action == self.action and self._joins(arc) for arc in arcs)

    def is_turned_among(self, arcs: Iterable[ActionArc]) -> bool:
        """Return whether a diagram has the arc with the parts of its action in any order."""
        return any(_parts(arc.action) == _parts(self.action) and self._joins(arc) for arc in arcs)

    def is_joined(self, arcs: Iterable[ActionArc]) -> bool:
        """Return whether a diagram has the arc with any action."""
        return any(self._joins(arc) for arc in arcs)

    def _joins(self, arc: ActionArc) -> bool:
        return matches(self.state, arc.state) and any(
            matches(pattern, arc.next_state) for pattern in self.next_states
        )


def _parts(action: str) -> frozenset[str]:
    """Return the controllers of an action."""
    return frozenset(action.split(SUBJECT_TO))


def diagram_of(experiences: Iterable[Experience], least: float = ABOVE) -> dict[ActionArc, float]:
    """Return the drawn arcs, with their share of the transitions that leave their state.

    Args:
        experiences: Episodes under a policy.
        least: Share above which an arc is drawn.
    """
    passed = Counter(
        ActionArc(each.state, each.action, each.next_state)
        for experience in experiences
        for each in experience.transitions
    )
    # Shares are relative to the transitions out of a state. A
    # state that is rarely visited may thus have drawn arcs.
    leaving: Counter[str] = Counter()
    for arc, count in passed.items():
        leaving[arc.state] += count
    shares = {arc: count / leaving[arc.state] for arc, count in sorted(passed.items())}
    return {arc: share for arc, share in shares.items() if share > least}

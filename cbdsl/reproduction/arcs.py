"""Arcs of transition diagrams: which state follows which, under a policy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.language.expression import SUBJECT_TO
from cbdsl.learning.experience import Experience
from cbdsl.reporting.drawing.policy_transitions import ABOVE
from cbdsl.types.state import matches


class ActionArc(NamedTuple):
    """A state, an action, and the state that followed."""

    state: str
    action: str
    next_state: str


@dataclass(frozen=True)
class DrawnArc:
    """An arc that the source has, or some arcs of which one is enough.

    Attributes:
        state: pattern of the state that it leaves.
        action: what is done there.
        next_states: patterns of the state that it leads to.
        context: of the stage; only there it is looked for, where it is not ``None``.
    """

    state: str
    action: str
    next_states: tuple[str, ...]
    context: str | None = None

    def __str__(self) -> str:
        where = f" ({self.context})" if self.context else ""
        return f"{self.state}, {self.action} → {' or '.join(self.next_states)}{where}"

    def is_among(self, arcs: Iterable[ActionArc]) -> bool:
        """Whether a diagram has it."""
        return any(arc.action == self.action and self._joins(arc) for arc in arcs)

    def is_turned_among(self, arcs: Iterable[ActionArc]) -> bool:
        """Whether a diagram has it with the parts of its action in whatever order."""
        return any(_parts(arc.action) == _parts(self.action) and self._joins(arc) for arc in arcs)

    def is_joined(self, arcs: Iterable[ActionArc]) -> bool:
        """Whether a diagram has it with any action."""
        return any(self._joins(arc) for arc in arcs)

    def _joins(self, arc: ActionArc) -> bool:
        return matches(self.state, arc.state) and any(
            matches(pattern, arc.next_state) for pattern in self.next_states
        )


def _parts(action: str) -> frozenset[str]:
    """The controllers of an action."""
    return frozenset(action.split(SUBJECT_TO))


def diagram_of(experiences: Iterable[Experience], least: float = ABOVE) -> dict[ActionArc, float]:
    """The arcs that are drawn, with the share of what leaves their state.

    Args:
        experiences: episodes under a policy.
        least: rarer ones are left out.
    """
    passed = Counter(
        ActionArc(each.state, each.action, each.next_state)
        for experience in experiences
        for each in experience.transitions
    )
    leaving: Counter[str] = Counter()
    for arc, count in passed.items():
        leaving[arc.state] += count
    shares = {arc: count / leaving[arc.state] for arc, count in sorted(passed.items())}
    return {arc: share for arc, share in shares.items() if share > least}

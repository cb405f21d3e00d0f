"""Decisions: transitions between choices, where programs are among the actions (Section 4.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from cbdsl.program.transition import Transition
from cbdsl.types.state import Predicate


class Decisions:
    """Filter that turns the transitions of a program into decisions.

    A program among the actions is one temporally extended action: it is not left before it ends,
    and the states that it passes meanwhile are no decisions.

    Args:
        programs: the actions that are programs, by the place of their predicates in a state.
    """

    def __init__(self, programs: Mapping[int, str]) -> None:
        self._programs = programs
        # Where the action began that runs, or the last one that ran.
        self._origin = ""

    def running(self, state: str) -> str | None:
        """Program that runs in a state, ``None`` where an action can be chosen."""
        return next(
            (name for place, name in self._programs.items() if state[place] == Predicate.TRANSIENT),
            None,
        )

    def over(self, transition: Transition) -> Transition | None:
        """Decision that a transition completes, from the state in which it was made.

        ``None`` while a program runs.
        """
        if self.running(transition.state) is None:
            self._origin = transition.state
        if self.running(transition.next_state) is not None:
            return None
        return replace(transition, state=self._origin)

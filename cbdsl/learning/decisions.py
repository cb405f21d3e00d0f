"""Decisions: transitions between choices if programs are among the actions (Section 4.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from cbdsl.program.transition import Transition
from cbdsl.types.state import Predicate


class Decisions:
    """Filter that turns the transitions of a program into decisions.

    A program among the actions is one temporally extended action. It cannot be left before it ends,
    and its intermediate states are no decisions.

    Args:
        programs: Actions that are programs, by the place of their predicates in a state.
    """

    def __init__(self, programs: Mapping[int, str]) -> None:
        self._programs = programs
        # State in which the current or last action began.
        self._origin = ""

    def running(self, state: str) -> str | None:
        """Return the program that runs in a state, or ``None`` if an action can be chosen."""
        return next(
            (name for place, name in self._programs.items() if state[place] == Predicate.TRANSIENT),
            None,
        )

    def over(self, transition: Transition) -> Transition | None:
        """Return the decision that a transition completes, from the state in which it was made.

        Return ``None`` while a program runs.
        """
        # Example with a program in the second place: the transitions XX to X0 and X0 to X1 are one
        # decision from XX to X1.
        if self.running(transition.state) is None:
            self._origin = transition.state
        if self.running(transition.next_state) is not None:
            return None
        return replace(transition, state=self._origin)

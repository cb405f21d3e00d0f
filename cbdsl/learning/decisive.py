"""Decisive learner: ACCOMMODATE for which an action that changes nothing leads nowhere."""

from __future__ import annotations

from cbdsl.learning.accommodate import Accommodate
from cbdsl.program.transition import Transition


class Decisive(Accommodate):
    """Q-learning in which what follows an action without a change of state is worth nothing.

    The loop of Algorithm 1 waits for a change of state, and never ends without one. Where it does,
    after a time, the state is worth what it was; if that counted, an action that fails would keep
    nearly all of its value, and be repeated until the transitions are used up.
    """

    def ends(self, decision: Transition) -> bool:
        """See ``Accommodate.ends``."""
        return super().ends(decision) or decision.state == decision.next_state

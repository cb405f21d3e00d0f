"""Decisive learner: ACCOMMODATE in which an action without effect ends the decision sequence."""

from __future__ import annotations

from cbdsl import Transition
from cbdsl.api.learning import Accommodate


class Decisive(Accommodate):
    """Q-learning in which the state after an action without change of state has no value.

    The loop of Algorithm 1 waits for a change of state, without a time limit. With a time limit,
    the state after a failed action has its former value. If that value counted, a failing action
    would keep most of its own value. It would be repeated until the transitions are used up.
    """

    def ends(self, decision: Transition) -> bool:
        """Return whether the state after a decision has no value (see ``Accommodate.ends``)."""
        return super().ends(decision) or decision.state == decision.next_state

"""The controller that leads a member of a state, and those that it waits for."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.runtime.controller_run import ControllerRun


class MemberLead(NamedTuple):
    """The controller that leads a member, and what the member optimises below it.

    Attributes:
        place: the member's place in the state.
        run: the controller with the highest priority.
        awaited: its other controllers that it is not at rest before: those that have no reference,
            and no goal but their rest, and those that a reward depends on.
        earners: its controllers that are rewarded; empty for no reward.
        conditions: its controllers that have to be at rest for a reward, and earn none.
    """

    place: int
    run: ControllerRun
    awaited: tuple[ControllerRun, ...]
    earners: tuple[ControllerRun, ...]
    conditions: tuple[ControllerRun, ...] = ()

    @property
    def predicate(self) -> str:
        """The leading controller's; at rest only when what is awaited below it is, too."""
        leading = self.run.predicate
        for run in self.awaited if leading == "1" else ():
            needed = run in self.earners or run in self.conditions
            if run.predicate == "0" or (needed and run.predicate != "1"):
                return "0"
        return leading

    @property
    def is_earned(self) -> bool:
        """Whether all that its reward depends on is at rest where it should be."""
        if not self.earners:
            return False
        needed = (*self.earners, *self.conditions)
        return all([run.predicate == "1" and run.settled for run in needed])

"""Leading controller of a member of a state, and the controllers it waits for."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.runtime.controllers.controller_run import ControllerRun


class MemberLead(NamedTuple):
    """Leading controller of a member, and the lower controllers that it waits for.

    Attributes:
        place: Index of the member in the state.
        run: Run of the controller with the highest priority.
        awaited: Runs that must rest first: controllers without a reference, whose only goal is
            rest, and controllers that a reward depends on.
        earners: Runs of the rewarded controllers; empty if no reward is possible.
        conditions: Runs that have to be at rest for a reward, but earn none.
    """

    place: int
    run: ControllerRun
    awaited: tuple[ControllerRun, ...]
    earners: tuple[ControllerRun, ...]
    conditions: tuple[ControllerRun, ...] = ()

    @property
    def predicate(self) -> str:
        """Predicate of the leading controller; at rest only if the awaited controllers are, too."""
        leading = self.run.predicate
        for run in self.awaited if leading == "1" else ():
            # A controller that only optimizes may be undefined without delaying the member. One
            # that a reward depends on must be at rest.
            needed = run in self.earners or run in self.conditions
            if run.predicate == "0" or (needed and run.predicate != "1"):
                return "0"
        return leading

    @property
    def arrived(self) -> bool:
        """True if the member is at rest, and its leading controller within its tolerance."""
        return self.predicate == "1" and self.run.arrived

    @property
    def stuck(self) -> bool:
        """True if the member is at rest, and its leading controller beyond its tolerance."""
        return self.predicate == "1" and self.run.stuck

    @property
    def is_earned(self) -> bool:
        """True if all controllers that its reward depends on are at rest within their bounds."""
        if not self.earners:
            return False
        needed = (*self.earners, *self.conditions)
        return all([run.predicate == "1" and run.settled for run in needed])

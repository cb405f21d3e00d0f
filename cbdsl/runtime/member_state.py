"""State of a program: the predicates of its members, read from their controllers."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.control.plan import ControllerPlan
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.runtime.action_levels import ActionLevels
from cbdsl.runtime.child_run import ChildRun


class MemberState:
    """Reader of a program's state, which reads again only after a change of a predicate.

    Args:
        program: Program with the members.
        levels: Controllers of its actions.
        children: Runs of its subprograms, by action.
        plan: Plan with the predicates of all controllers.
        slots: Slots of the program's controllers in the plan.
    """

    def __init__(
        self,
        program: CheckedProgram,
        levels: ActionLevels,
        children: Mapping[str, ChildRun],
        plan: ControllerPlan,
        slots: slice,
    ) -> None:
        self._program, self._levels, self._children = program, levels, children
        self._plan, self._slots = plan, slots
        # Codes of the predicates at the last reading, and the state read from them.
        self._noted, self._reading = b"", ""

    def forget(self) -> None:
        """Read anew, because another action begins."""
        self._noted = b""

    def read(self, action: Action) -> str:
        """Return the members' predicates while an action runs."""
        # Most ticks change no predicate, and a comparison of bytes shows this immediately. The
        # controllers of a child have other slots, so that its predicate is read in any case.
        noted = self._plan.predicates[self._slots].tobytes()
        if noted != self._noted or action.program is not None:
            self._noted, self._reading = noted, self._read_members(action)
        return self._reading

    def _read_members(self, action: Action) -> str:
        state = ["X"] * len(self._program.members)
        if action.program is not None:
            own = self._children[action.name].predicate
            # A program that waits for its companions is part of the active action, and X would mean
            # that it is not.
            is_waiting = action.composition is not None and own == "X"
            state[self._program.members.index(action.part)] = "-" if is_waiting else own
        for lead in self._levels.leads.get(action.name, ()):
            state[lead.place] = lead.predicate
        return "".join(state)

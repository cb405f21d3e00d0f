"""Action switch: controllers and subprograms of actions, started and stopped together."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.program.checked import Action
from cbdsl.runtime.action_levels import ActionLevels
from cbdsl.runtime.child_run import ChildRun


class ActionSwitch:
    """Starts and stops of a program's actions.

    Args:
        levels: Controllers of the actions.
        children: Runs of the subprograms, by action.
    """

    def __init__(self, levels: ActionLevels, children: Mapping[str, ChildRun]) -> None:
        self._levels, self._children = levels, children

    def start(self, action: Action, before: Action | None) -> None:
        """Start an action in place of another one, if any."""
        if before is not None:
            self._leave(before, action)
        child = self._children.get(action.name)
        if child is not None and action.composition is None:
            child.activate()
        elif child is not None and child.predicate in "1-":
            child.deactivate()  # it waits again
        for run in self._levels.stacks.get(action.name, ()):
            run.activate()

    def stop(self, action: Action) -> None:
        """Stop an action."""
        child = self._children.get(action.name)
        if child is not None:
            child.deactivate()
        for run in self._levels.stacks.get(action.name, ()):
            run.deactivate()

    def _leave(self, before: Action, after: Action) -> None:
        child = self._children.get(before.name)
        if child is not None and child is not self._children.get(after.name):
            child.deactivate()
        # Controllers of both actions go on without interruption.
        kept = self._levels.stacks.get(after.name, ())
        for run in self._levels.stacks.get(before.name, ()):
            if run not in kept:
                run.deactivate()

    def is_awaited(self, action: Action) -> bool:
        """Return whether a program that waits for its accompanying controllers begins now."""
        if action.composition is None or self._children[action.name].predicate != "X":
            return False
        return all(lead.predicate == "1" for lead in self._levels.leads[action.name])

    def restart_quiescence(self, action: Action) -> None:
        """Restart the quiescence of controllers that wait for a search while it goes on."""
        for seeker, waiting in self._levels.waiting.get(action.name, ()):
            if seeker.seeking:
                for run in waiting:
                    run.restart_quiescence()

    def restart_background(self) -> None:
        """Let the background begin again."""
        for run in self._levels.background:
            run.deactivate()
            run.activate()

"""Active levels: controllers of the action or search that runs now, above the background."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cbdsl.program.checked import Action
from cbdsl.runtime.action_levels import ActionLevels, Active
from cbdsl.runtime.child_run import ChildRun


class ActiveLevels:
    """Levels that act now, composed again only when a child's levels change.

    Args:
        levels: Levels of the actions.
        children: Runs of the subprograms, by action.
    """

    def __init__(self, levels: ActionLevels, children: Mapping[str, ChildRun]) -> None:
        self._levels, self._children = levels, children
        # Active levels of the current child, and the same above the background.
        self._of_child: Sequence[Active] | None = None
        self._all: Sequence[Active] = ()
        self.forget()

    def forget(self) -> None:
        """Compose again, because the run begins."""
        self._of_action = ""

    def of_search(self, search: ChildRun) -> Sequence[Active]:
        """Return the levels while a program searches for a feature."""
        acting = search.active()
        if acting is not self._of_child:
            self._of_child, self._all = acting, self._levels.above_background(acting)
        return self._all

    def of_action(self, action: Action) -> Sequence[Active]:
        """Return the levels while an action runs."""
        child = self._children.get(action.name)
        if child is None:
            return self._levels.acting[action.name]
        acting = child.active()
        # A child returns the same object while the same controllers act, so that identity suffices.
        if acting is not self._of_child or action.name != self._of_action:
            self._of_child, self._all = acting, self._levels.with_child(action, acting)
            self._of_action = action.name
        return self._all

"""Runs of a program's actions: their controllers and subprograms, levels and predicates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeVar

from cbdsl.control.plan import ControllerPlan
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.runtime.action_levels import ActionLevels, Active
from cbdsl.runtime.controllers.controller_run import ControllerRun


class ChildRun(Protocol):
    """Run of a program inside another one; see ``ProgramRun``."""

    predicate: str
    rewarded: bool

    def activate(self) -> None: ...
    def advance(self) -> None: ...
    def deactivate(self) -> None: ...
    def active(self) -> Sequence[Active]: ...


class ActionRuns:
    """Actions of a program, started and stopped, with their active levels and the program's state.

    Args:
        program: Program with the actions.
        levels: Controllers of the actions.
        children: Runs of the subprograms, by action.
        plan: Plan with the predicates of all controllers.
        slots: Slots of the program's controllers in the plan.
        conditions: Numbers of the program's conditions in the plan, by name.
    """

    def __init__(
        self,
        program: CheckedProgram,
        levels: ActionLevels,
        children: Mapping[str, ChildRun],
        plan: ControllerPlan,
        slots: Sequence[int],
        conditions: Mapping[str, int],
    ) -> None:
        self._program, self._levels, self._children = program, levels, children
        self._plan, self._slots, self._conditions = plan, slots, conditions
        # Members that act: conditions are the last ones.
        self._acting = len(program.members) - len(conditions)
        # Active levels of the current child, and the same above the background.
        self._of_child: Sequence[Active] | None = None
        self._all: Sequence[Active] = ()
        # Codes of the predicates at the last reading, and the state read from them.
        self._noted, self._reading = b"", ""
        # Controllers and child that an edited program has taken over with an action of before.
        self._taken_over: tuple[Sequence[ControllerRun], ChildRun | None] = (), None
        self.forget()

    def succeed(self, before: ActionRuns, action: Action) -> None:
        """Take over the controllers of a running action, until another action starts."""
        before._plan.conditions.watch((), before._numbers(action))
        runs = before._levels.stacks.get(action.name, ())
        self._taken_over = runs, before._children.get(action.name)

    def forget(self) -> None:
        """Compose the levels again, because the run begins."""
        self._of_action = ""
        self._plan.conditions.watch((), tuple(self._conditions.values()))

    def start(self, action: Action, before: Action | None) -> None:
        """Start an action in place of another one, if any."""
        self._plan.conditions.watch(self._numbers(action), self._numbers(before))
        self._noted = b""  # the members of the other action are read anew
        self._leave(*self._taken_over, action)
        self._taken_over = (), None
        if before is not None:
            runs = self._levels.stacks.get(before.name, ())
            self._leave(runs, self._children.get(before.name), action)
        child = self._children.get(action.name)
        if child is not None and action.composition is None:
            child.activate()
        elif child is not None and child.predicate in "1-":
            child.deactivate()  # it waits again
        for run in self._levels.stacks.get(action.name, ()):
            run.activate()

    def stop(self, action: Action) -> None:
        """Stop an action."""
        self._plan.conditions.watch((), self._numbers(action))
        child = self._children.get(action.name)
        if child is not None:
            child.deactivate()
        for run in self._levels.stacks.get(action.name, ()):
            run.deactivate()

    def _numbers(self, action: Action | None) -> tuple[int, ...]:
        """Return the numbers of the conditions that are evaluated while an action runs."""
        return () if action is None else tuple(self._conditions[n] for n in action.conditions)

    def strives(self, action: Action, state: str) -> bool:
        """Return whether a member of an action is transient or seeks."""
        acts = "0" in state[: self._acting]
        return acts or any(run.seeking for run in self._levels.stacks[action.name])

    def _leave(self, runs: Sequence[ControllerRun], child: ChildRun | None, after: Action) -> None:
        if child is not None and child is not self._children.get(after.name):
            child.deactivate()
        # Controllers of both actions go on without interruption.
        kept = self._levels.stacks.get(after.name, ())
        for run in runs:
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

    def read(self, action: Action) -> str:
        """Return the members' predicates while an action runs."""
        # Most ticks change no predicate, and a comparison of bytes shows this immediately. The
        # controllers of a child have other slots, so that its predicate is read in any case.
        noted = self._plan.predicates[self._slots].tobytes()
        if action.conditions:
            noted += "".join(self._letters(action)).encode()
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
        for name, letter in zip(action.conditions, self._letters(action), strict=True):
            state[self._program.members.index(name)] = letter
        return "".join(state)

    def _letters(self, action: Action) -> list[str]:
        """Return the predicates of an action's conditions."""
        return [self._plan.conditions.letter(number) for number in self._numbers(action)]


Run = TypeVar("Run")


def subprogram_runs(
    program: CheckedProgram, make: Callable[[CheckedProgram, str], Run]
) -> dict[str, Run]:
    """Return the runs of subprograms by action, one for each member and allocation.

    Args:
        program: Program with the actions.
        make: Function of a subprogram and the name of its member that returns a run.
    """
    made: dict[tuple[str, str], Run] = {}
    runs = {}
    for action in program.actions:
        if action.program is None:
            continue
        key = action.part, action.allocation
        if key not in made:
            made[key] = make(action.program, action.part)
        runs[action.name] = made[key]
    return runs

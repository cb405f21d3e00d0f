"""Levels of control: the controllers that act together, by priority."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.controllers.controller_runs import ControllerRuns


class Active(NamedTuple):
    """Controller that acts now, with the controllers it acts together with."""

    run: ControllerRun
    peers: Mapping[str, ControllerRun]


class ActionLevels:
    """Levels of each action of a program above its background, highest priority first.

    Args:
        program: Program that has the actions.
        make: Factory of the controllers' runs.

    Attributes:
        background: Controllers that act below every action.
        alone: Levels of the background alone.
        stacks: Controllers of each action, by its name; an action that is only a program has none.
        waiting: Seeking controllers of each stack, with the controllers that wait meanwhile.
        leads: Controllers of each stack that determine the members' predicates.
        acting: Levels while a stack acts.
    """

    def __init__(self, program: CheckedProgram, make: ControllerRuns) -> None:
        composed = {
            action.name: action.composition
            for action in program.actions
            if action.composition is not None
        }
        # The order of creation is the order of the rows in the plan.
        self.stacks = {name: make.stack(own) for name, own in composed.items()}
        self.waiting = {name: list(make.waiting(own)) for name, own in composed.items()}
        self.background = make.stack(program.background) if program.background else ()
        self.alone = self.above_background(())
        self.acting = {
            action.name: self._levels(self.stacks[action.name], _below(action, make))
            for action in program.actions
            if action.name in composed
        }
        self.leads = {
            name: [
                make.lead(primitive, program.members.index(primitive.name))
                for primitive in own.primitives
            ]
            for name, own in composed.items()
        }

    def above_background(self, acting: Sequence[Active]) -> tuple[Active, ...]:
        """Return the levels with the remaining background controllers below them."""
        running = [item.run for item in acting]
        below = [Active(run, {}) for run in self.background if run not in running]
        return (*acting, *below)

    def of_stack(self, runs: Sequence[ControllerRun]) -> tuple[Active, ...]:
        """Return the levels while some controllers act, which may also require the background."""
        return self._levels(runs, None)

    def with_child(self, action: Action, acting: Sequence[Active]) -> tuple[Active, ...]:
        """Return the levels of a program among the controllers that it is composed with, if any."""
        runs = self.stacks.get(action.name)
        if runs is None:
            return self.above_background(acting)
        # The action's own controllers come first in its levels, and the background follows. The
        # child's levels stand between the companions above it and those below it.
        own = self.acting[action.name][: len(runs)]
        taken = {item.run for item in (*own, *acting)}
        below = [item for item in self.alone if item.run not in taken]
        return (*own[: action.above], *acting, *own[action.above :], *below)

    def _levels(
        self, runs: Sequence[ControllerRun], below: Sequence[ControllerRun] | None
    ) -> tuple[Active, ...]:
        """Return the levels of controllers, whose peers are each other and the controllers below.

        Args:
            runs: Runs of the controllers, highest priority first.
            below: Lower controllers, highest priority first; ``None`` for the program's background.
        """
        below = self.background if below is None else below
        peers = {run.controller.name: run for run in (*below, *runs)}
        return self.above_background([Active(run, peers) for run in runs])


def _below(action: Action, make: ControllerRuns) -> Sequence[ControllerRun] | None:
    """Return the background of an action's allocation, or ``None`` for the program's."""
    return None if action.background is None else make.stack(action.background)

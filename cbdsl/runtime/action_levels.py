"""Levels of control: the controllers that act together, by priority."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.controller_runs import ControllerRuns


class Active(NamedTuple):
    """A controller that acts now, and the controllers it acts together with."""

    run: ControllerRun
    peers: Mapping[str, ControllerRun]


class ActionLevels:
    """Levels of each action of a program, above its background; each highest priority first.

    Args:
        program: whose actions.
        make: makes the runs of their controllers.

    Attributes:
        background: controllers that act below every action.
        alone: levels of the background alone.
        stacks: an action's own controllers, by its name; a program by itself has none.
        waiting: of a stack, controllers that seek, each with those that wait meanwhile.
        leads: of a stack, controllers that give the members' predicates.
        acting: levels while a stack acts.
    """

    def __init__(self, program: CheckedProgram, make: ControllerRuns) -> None:
        composed = {
            action.name: action.composition
            for action in program.actions
            if action.composition is not None
        }
        # The order in which controllers are met is that of their rows in the plan.
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
        """Levels, and below them the background, as far as it is not among them."""
        running = [item.run for item in acting]
        below = [Active(run, {}) for run in self.background if run not in running]
        return (*acting, *below)

    def of_stack(self, runs: Sequence[ControllerRun]) -> tuple[Active, ...]:
        """Levels while some controllers act, which may require what is in the background, too."""
        return self._levels(runs, None)

    def with_child(self, action: Action, acting: Sequence[Active]) -> tuple[Active, ...]:
        """Levels of a program, among the controllers that it is composed with, if any."""
        runs = self.stacks.get(action.name)
        if runs is None:
            return self.above_background(acting)
        own = self.acting[action.name][: len(runs)]
        taken = {item.run for item in (*own, *acting)}
        below = [item for item in self.alone if item.run not in taken]
        return (*own[: action.above], *acting, *own[action.above :], *below)

    def _levels(
        self, runs: Sequence[ControllerRun], below: Sequence[ControllerRun] | None
    ) -> tuple[Active, ...]:
        """Levels of controllers, whose peers are each other and what is below them.

        Args:
            below: highest priority first; the program's background without.
        """
        below = self.background if below is None else below
        peers = {run.controller.name: run for run in (*below, *runs)}
        return self.above_background([Active(run, peers) for run in runs])


def _below(action: Action, make: ControllerRuns) -> Sequence[ControllerRun] | None:
    """The background of an action's own allocation: of several, that of the same hand."""
    return None if action.background is None else make.stack(action.background)

"""Parts of a program's run that its program determines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from cbdsl.control.plan import ControllerPlan
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.program.transition import title_of
from cbdsl.runtime.action_clock import ActionClock
from cbdsl.runtime.action_levels import ActionLevels
from cbdsl.runtime.action_runs import ActionRuns, ChildRun, subprogram_runs
from cbdsl.runtime.context_reader import ContextReader, FeatureLooks
from cbdsl.runtime.controllers.controller_runs import ControllerRuns
from cbdsl.runtime.fruitless_loop import FruitlessLoop
from cbdsl.runtime.lost_objects import LostObjects
from cbdsl.runtime.policies.learned_policy import own_policy
from cbdsl.runtime.rewards import Rewards
from cbdsl.sensing.signals import Signals

Run = TypeVar("Run", bound=ChildRun)


class ProgramParts(Generic[Run]):
    """Parts of a program's run that its program determines; an edited program has others.

    Attributes:
        title: Name of the program and of its use.
        written: Policy of the program.
        actions: Actions by abstract action and allocation, or by name alone.
        levels: Levels of its actions.
        lost: Finder of its lost objects.
        children: Runs of the programs that it uses.
        looks: Searches for undefined features.
        running: Runs of its actions.
        rewards: Rules that reward or conclude it.
        clock: Times of its actions.
        loop: Finder of its fruitless loops.

    Args:
        program: Program.
        use: Name of its use; empty for the main program.
        signals: Signals of the robot.
        plan: Plan that receives slots and conditions.
        period: Period of the ticks, s.
        controllers: Factory of the controllers' runs.
        child: Function that returns the run of a program that is used under a name.
    """

    def __init__(
        self,
        program: CheckedProgram,
        use: str,
        signals: Signals,
        plan: ControllerPlan,
        period: float,
        controllers: ControllerRuns,
        child: Callable[[CheckedProgram, str], Run],
    ) -> None:
        self.title, self.written = title_of(program.name, use), own_policy(program)
        schema = program.schema
        self._context = None if schema is None else ContextReader(schema, signals)
        # An action of a schema is chosen by its abstract action and allocation, or by its own name.
        self.actions: dict[tuple[str, str], Action] = {
            (action.name, ""): action for action in program.actions
        }
        self.actions |= {(each.abstract, each.allocation): each for each in program.actions}
        self.levels = ActionLevels(program, controllers)
        self.lost = LostObjects(program, signals.vision, signals.robot.vision.channels.aliases)
        controllers.aim()
        conditions = {
            name: plan.conditions.add(each, {r: signals.bind(r) for r in each.resources}, period)
            for name, each in program.conditions.items()
        }
        self.children: dict[str, Run] = subprogram_runs(program, child)
        looks = {
            feature: child(look.program, f"look for {feature}")
            for feature, look in program.looks.items()
        }
        self.looks = FeatureLooks(looks, self._context)
        # These keys differ from all names of actions, because they consist of several words.
        self.children |= {f"look for {feature}": each for feature, each in looks.items()}
        slots = [run.slot for run in controllers.all]
        self.running = ActionRuns(program, self.levels, self.children, plan, slots, conditions)
        self.rewards = Rewards(program, self.levels, self.children)
        self.clock = ActionClock(program, period)
        self.loop = FruitlessLoop(program, signals)

    def read_context(self) -> Features:
        """Return the features of the program's schema; none without a schema."""
        return NO_FEATURES if self._context is None else self._context.read()

    def no_action(self, reason: str, state: str, ran: str) -> str:
        """Return the reason for an end by a policy that chose no action.

        Args:
            reason: Reason of the policy; empty for none.
            state: State of the program.
            ran: Name of the action that ran without changing the state; empty for none.
        """
        if reason:
            return f"{self.title}: {reason}"
        if not ran:
            return f"{self.title} has no action for state {state}"
        return f"{ran} changed nothing in {self.clock.seconds:.0f} s (state {state})"

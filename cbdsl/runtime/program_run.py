"""Run of one program: predicates, state transitions and rewards (Algorithm 1)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial

import numpy as np

from cbdsl.control.plan import ControllerPlan
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.edit import EditTaken, continuation
from cbdsl.program.schema import NO_FEATURES, Features
from cbdsl.program.transition import Transition
from cbdsl.robot.channel_names import named_colors
from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.action_runs import ChildRun
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.controllers.controller_runs import ControllerRuns
from cbdsl.runtime.policies.policy import Choice, DeferredPolicy, Policy
from cbdsl.runtime.program_parts import ProgramParts
from cbdsl.sensing.signals import Signals


# The state of a program is the tuple of its members' predicates (Eq 4.1): X inactive, - undefined,
# 0 transient, 1 quiescent. A policy maps a state to an action, which acts until the state changes
# (lines 8 to 14 of Algorithm 1). Member i is rewarded if its predicate becomes 1 and was not 1
# before (Eq 4.2). In addition, its controller has to track a signal of the environment (Eq 4.3).
# Three rules go beyond the algorithm. An action also ends without a change of state, once its time
# is over. A program may be an action of another program, and its own predicate is then a member's.
# Programs may state success and failure, which have precedence over rewards.
class ProgramRun:
    """Run of a program that chooses actions by its members' predicates and has one itself.

    Attributes:
        program: Program that runs.
        state: Predicates, one character per member.
        predicate: Predicate of the program as an action: 0 running, 1 achieved, - ended without, X
            idle.
        rewarded: True if a transition was rewarded: the last, if a reward ends the program.
        outcome: ``success`` or ``failure`` if its state is one of these; empty otherwise.
        ending: Reason of the end, as a clause; empty while it runs.
        is_open: True if a deferred choice is pending for ``decide``.
    """

    def __init__(
        self,
        program: CheckedProgram,
        signals: Signals,
        plan: ControllerPlan,
        period: float,
        depth: int = 0,
        use: str = "",
    ) -> None:
        self._use, self._depth = use, depth
        self._signals, self._context = signals, (signals, plan, period)
        self._controllers = ControllerRuns(signals, plan, period)
        self.children: dict[str, ProgramRun] = {}
        self._rng: np.random.Generator | None = None
        self._offered: CheckedProgram | None = None
        self._action: Action | None = None
        self.predicate, self.state = "X", ""
        self._load(program)
        self._policy = self._parts.written

    def _load(self, program: CheckedProgram) -> None:
        """Build the parts of a program; controllers and programs that it had before are kept."""
        self._controllers, self.program = self._controllers.successor(), program
        child = partial(self._inner, self.children)
        self._parts = ProgramParts(program, self._use, *self._context, self._controllers, child)
        self.children = self._parts.children
        self.runs: tuple[ControllerRun, ...] = self._controllers.all

    def begin(
        self,
        rng: np.random.Generator,
        listener: Callable[[Transition], None],
        policy: Policy | None = None,
    ) -> None:
        """Begin an episode; discard the last.

        Args:
            rng: Source of all samples.
            listener: Listener that receives each transition, also of programs used as actions.
            policy: Policy that chooses the actions in place of the program's written policy.
        """
        self._listener, self._rng = listener, rng
        self._policy = policy or self._parts.written
        # A learner learns to be rewarded, so a reward ends its episodes.
        self._reward_ends = self.program.reward_ends or policy is not None
        for run in self.runs:
            run.begin(rng)
        # Actions of the same part and allocation share a child.
        for child in dict.fromkeys(self.children.values()):
            child.begin(rng, listener)
        self.deactivate()

    def offer(self, program: CheckedProgram, listener: Callable[[EditTaken], None]) -> None:
        """Go on as an edited program from the next change of state, or now if it is idle.

        Its subprograms do so at their own changes. Controllers that stay the same go on.

        Args:
            program: Edited program for the same robot; without a schema.
            listener: Listener that receives each program that is replaced.
        """
        self._offered = None if program == self.program else program
        self._on_edit = listener
        for action in program.actions:
            child = self.children.get(action.name)
            if child is not None and action.program is not None:
                child.offer(action.program, listener)
        if self.predicate == "X":
            self._replace()

    def _replace(self, note: str = "it begins with its first step") -> None:
        """Become the offered program, if any."""
        program, self._offered = self._offered, None
        if program is None:
            return
        known, parts, followed = set(self.runs), self._parts, self.is_written
        self._load(program)
        self._parts.clock.succeed(parts.clock)
        if followed:
            self._policy = self._parts.written
        self._on_edit(EditTaken(program, self._parts.title, self._depth, self._signals.time, note))
        if self._rng is None:
            return  # no episode has begun
        for run in self.runs:
            if run not in known:
                run.begin(self._rng)
        for child in self.children.values():
            if child._rng is None:
                child.begin(self._rng, self._listener)
        self._policy.begin()
        self._reward_ends = program.reward_ends or not followed
        for run in self.background if self.predicate == "0" else ():
            run.activate()

    def _take_up(self, *, changed: bool) -> bool:
        """Become the offered program at a change of state; return whether its exits decide."""
        before, action, running = self.program, self._action, self._parts.running
        assert self._offered is not None
        assert action is not None
        child = self.children.get(action.name)
        ran = None if child is None else child.program
        to = continuation(before, self._offered, action, ran, changed=changed)
        letters = dict(zip(before.members, self.state, strict=True))
        self._replace(to.note)
        self._parts.running.succeed(running, action)
        if to.decides:
            self.state = "".join(letters.get(each, "X") for each in self.program.members)
            self._action = self._parts.actions[to.action, ""]
            return True
        self.state, self._action = "X" * len(self.program.members), None
        if to.action:
            self._begin_action(Choice(to.action), NO_FEATURES, changed=True)
        else:
            self._choose(changed=True)
        return False

    def deactivate(self) -> None:
        """Stop, and forget the activation."""
        for run in self.runs:
            run.deactivate()
        for child in self.children.values():
            child.deactivate()
        self.predicate = "X"
        self._replace()
        self.state = "X" * len(self.program.members)
        self.ending = self.outcome = ""
        self.rewarded = False
        self.transitions = 0
        self.is_open = self._was_changed = False
        self._action = None
        self._withdraws = False
        self._parts.looks.forget()
        self._parts.running.forget()
        self._composed: Sequence[Active] | None = None
        self._features: Features = NO_FEATURES
        self._parts.clock.restart()
        self._parts.loop.forget()

    def activate(self) -> None:
        """Start from the beginning unless it is running."""
        if self.predicate == "0":
            return
        self.deactivate()
        self.predicate = "0"
        self._policy.begin()
        for run in self.background:
            run.activate()
        if not (self._policy.allocates and self._parts.looks.begin()):
            self._choose(changed=True)

    def _look_on(self, look: ChildRun) -> None:
        """Advance the search; choose an action once all searches have ended."""
        self._parts.clock.advance_search()
        if not self._parts.looks.advance(look):
            self._choose(changed=True)

    @property
    def background(self) -> Sequence[ControllerRun]:
        """Controllers that act below every action, highest priority first."""
        return self._parts.levels.background

    @property
    def action(self) -> Action | None:
        """The action that runs now."""
        return self._action

    @property
    def is_written(self) -> bool:
        """True if the program's own policy chooses its actions."""
        return self._policy is self._parts.written

    @property
    def stuck(self) -> tuple[str, ...]:
        """Members of the running action at rest beyond their tolerance, in written order."""
        return () if self._action is None else self._parts.rewards.stuck(self._action)

    def active(self) -> Sequence[Active]:
        """Return the active levels, highest priority first, down to the background.

        The returned object stays the same while the same controllers act.
        """
        if self._composed is not None:
            return self._composed
        if self._withdraws:
            return self._parts.levels.alone
        look = self._parts.looks.current
        if look is not None:
            return self._parts.running.of_search(look)
        return () if self._action is None else self._parts.running.of_action(self._action)

    def compose(self, names: Sequence[str] | None) -> None:
        """Let a stack act in place of actions, above the background.

        Meanwhile the program has no transitions, earns no reward and does not end.

        Args:
            names: Controllers of the program, highest priority first; ``None`` returns the choice
                to the program, from the state in which no controller is active.
        """
        named = {run.controller.name: run for run in self.runs}
        stack = tuple(named[name] for name in names or ())
        if self.predicate != "0":
            return  # its episode is over
        for run in self.runs:
            if run not in stack and run not in self.background:
                run.deactivate()
        for child in self.children.values():
            child.deactivate()
        for run in stack:
            run.activate()
        self._action, self._withdraws = None, False
        if names is not None:
            self._composed = self._parts.levels.of_stack(stack)
            return
        self._composed = None
        self._replace()
        self.state = "X" * len(self.program.members)
        self._choose(changed=True)

    def _inner(
        self, kept: Mapping[str, ProgramRun], program: CheckedProgram, name: str
    ) -> ProgramRun:
        """Return the run of a program that is used under a name; one of before goes on."""
        use = f"{self._use}.{name}" if self._use else name
        for each in kept.values():
            if each._use == use:
                each.offer(program, self._on_edit)
                return each
        return ProgramRun(program, *self._context, self._depth + 1, use)

    @property
    def succeeded(self) -> bool:
        """True if its state is a success or, without an outcome, a reward or its rest decided so.

        Rewards on the way to a stated success decide nothing.
        """
        if self.outcome:
            return self.outcome == "success"
        return self.predicate == "1" or (self.rewarded and not self.program.success)

    @property
    def colors(self) -> Collection[str]:
        """Named colours of the robot."""
        return named_colors(self._signals.robot.vision.channels)

    @property
    def losses(self) -> tuple[str, ...]:
        """One clause for each object that was seen and has no remembered position."""
        return tuple(map(str, self._parts.lost.find(self._signals.time)))

    def leads(self, action: Action) -> list[ControllerRun]:
        """Return the leading controllers of an action's primitives, highest priority first."""
        return [lead.run for lead in reversed(self._parts.levels.leads.get(action.name, []))]

    def advance(self) -> None:
        """Read the predicates of this tick; change the action if the state changed."""
        if self.predicate != "0" or self.is_open or self._composed is not None:
            return
        look = self._parts.looks.current
        if look is not None:
            self._look_on(look)
        elif self._withdraws:
            self._withdraw()
        elif self._action is not None:
            self._act(self._action)
        if self.predicate == "0" and self._parts.clock.is_episode_over:
            # A program that states its success is achieved in one of these states only.
            is_done = self.rewarded and not self.program.success
            limit = f"the {self.program.episode_time:g} s of {self._parts.title}"
            self._end("1" if is_done else "-", f"{limit} were over")
        self._end_without_objects()

    def _end_without_objects(self) -> None:
        """End a program whose objects have been lost for as long as it allows."""
        limit = self.program.lost_time
        if limit is None or self.predicate != "0":
            return
        if any(loss.seconds >= limit for loss in self._parts.lost.find(self._signals.time)):
            self.outcome = "failure" if self.program.success or self.program.failure else ""
            self._end("-", "")

    def _withdraw(self) -> None:
        """Wait until the background is at rest, then choose again."""
        self._parts.clock.advance()
        if self._parts.clock.is_over or all(run.predicate != "0" for run in self.background):
            self._withdraws = False
            self._choose(changed=True)

    def _act(self, action: Action) -> None:
        child = self.children.get(action.name)
        if child is not None and self._parts.running.is_awaited(action):
            child.activate()
        # The child is first, because its predicate is part of the state that is read below.
        if child is not None:
            child.advance()
        clock, running = self._parts.clock, self._parts.running
        clock.advance()
        running.restart_quiescence(action)
        state = running.read(action)
        # A program limits its own transitions. It may also end again with its last predicate
        # within one tick, and then it is over although the state has not changed.
        if child is None or action.composition is not None:
            # Its time is over, in total or without activity.
            overdue = clock.is_over or clock.is_idle(strives=running.strives(action, state))
        else:
            overdue = child.predicate != "0"
        if state != self.state or overdue:
            self._transit(state)

    def _transit(self, state: str) -> None:
        assert self._action is not None
        changed = state != self.state
        rewarding = self._parts.rewards.rewarding(self._action, self.state, state)
        # An edited program decides instead.
        is_edited = self._offered is not None
        conclusion = None if is_edited else self._parts.rewards.conclusion(state, self.stuck)
        self.transitions += 1
        self._listener(
            Transition(
                self.program.name,
                self._depth,
                self._signals.time,
                self.state,
                self._action.name,
                state,
                self._parts.clock.ticks,
                len(rewarding),
                rewarding,
                self._action.allocation,
                self._features,
                self._use,
                "" if conclusion is None else conclusion.reason,
                self.stuck,
            )
        )
        self.state = state
        self.rewarded |= bool(rewarding)
        if is_edited:
            if not self._take_up(changed=changed):
                return
            conclusion, state = self._parts.rewards.conclusion(self.state, self.stuck), self.state
        # A stated success or failure has precedence over a reward and over the number of
        # transitions.
        if conclusion is not None:
            self.outcome = conclusion.outcome
            self._end("1" if conclusion.outcome == "success" else "-", conclusion.reason)
        elif rewarding and self._reward_ends:
            self._end("1", "")
        elif self.transitions >= self.program.transitions:
            self._end("-", f"{self._parts.title} used up its {self.transitions} transitions")
        # A learner may try actions again that have changed nothing.
        elif self.is_written and (loop := self._parts.loop.note(self._action.name, state)):
            self._end("-", f"{self._parts.title} {loop}")
        else:
            self._choose(changed=changed)

    def _choose(self, *, changed: bool) -> None:
        if isinstance(self._policy, DeferredPolicy):
            self.is_open, self._was_changed = True, changed
            return
        features = self._parts.read_context()
        tells_rest = self._policy.tells_rest and self._action is not None
        state = self._parts.rewards.with_rests(self.state, self.stuck) if tells_rest else self.state
        choice = self._policy.choose(state, changed=changed, features=features)
        if choice.withdraws:
            self._begin_withdrawal()
        else:
            self._begin_action(choice, features, changed)

    def decide(self, name: str | None) -> None:
        """Make the pending choice.

        Args:
            name: Name of an action; ``None`` ends the program.
        """
        if not self.is_open:
            raise ValueError("no choice is open")
        self.is_open = False
        self._begin_action(Choice(name), self._parts.read_context(), self._was_changed)

    def _begin_action(self, choice: Choice, features: Features, changed: bool) -> None:
        if choice.action is None:
            is_done = self.rewarded and not self._reward_ends
            parts, state = self._parts, self.state
            final = parts.rewards.final(state, self.stuck, changed=changed, is_done=is_done)
            ran = "" if changed or self._action is None else self._action.name
            self._end(final, parts.no_action(choice.reason, state, ran))
            return
        before, self._action = self._action, self._parts.actions[choice.action, choice.allocation]
        self._features = {k: value for k, value in features.items() if not math.isnan(value)}
        self._parts.clock.begin_action()
        self._parts.running.start(self._action, before)

    def _begin_withdrawal(self) -> None:
        """Leave all control to the background until it is at rest."""
        if self._action is not None:
            self._parts.running.stop(self._action)
        self._parts.running.restart_background()
        self._action, self._withdraws = None, True
        self._parts.clock.begin_action()

    def _end(self, predicate: str, ending: str) -> None:
        self.predicate = predicate
        self.ending = ending

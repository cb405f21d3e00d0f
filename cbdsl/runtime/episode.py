"""One episode: a program, a backend and a stage, from reset to the end."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from itertools import count
from typing import NamedTuple

import numpy as np

from cbdsl.backends.backend import Backend
from cbdsl.backends.backend_calls import BackendCalls
from cbdsl.control.plan import ControllerPlan
from cbdsl.control.potentials.multigrid import ConvergenceError
from cbdsl.control.signal import SignalError
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.program.edit import EditTaken
from cbdsl.program.transition import Transition
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.ending import (
    describe,
    describe_lateness,
    describe_stop,
    lacks_color,
    stuck_leads,
)
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.policies.policy import Policy
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.sensor_faults import SensorError
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import Resource

# Observer that ignores all calls.
_SILENT = EpisodeObserver()


class EpisodeError(UsageError):
    """Error of an episode that cannot go on; the message gives seed, time and reason."""


class DeadlineError(EpisodeError):
    """Error of a control tick that took longer than its backend allows.

    Attributes:
        result: Result of the episode, whose ending is the message.
    """

    def __init__(self, result: EpisodeResult) -> None:
        super().__init__(f"seed {result.seed}: {result.ending}")
        self.result = result


class _Begun(NamedTuple):
    """Episode that has begun: stage, context, seed, start time, and its transitions."""

    stage: str
    context: str
    seed: int
    time: float
    passed: list[Transition]


class Runner:
    """Runner of episodes of one program with one backend.

    Args:
        robot: Robot that the program was checked against.
        kinematics: Kinematics of the same robot.
        program: Program to run.
        backend: Backend to run it on.
        policy: Policy that chooses the actions in place of the program's written policy.
        clock: Clock for the deadlines, wall time, s.
        observed: Resources that listeners read besides those of the program.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        program: CheckedProgram,
        backend: Backend,
        policy: Policy | None = None,
        *,
        clock: Callable[[], float] = time.perf_counter,
        observed: Sequence[Resource] = (),
    ) -> None:
        self._program = program
        self._clock, self.observed = clock, tuple(observed)
        self._backend, self._calls = backend, BackendCalls(backend, robot)
        self._policy = policy
        guards, sensed = program.all_guards, (*resources_of(program), *observed)
        self.signals = Signals(robot, kinematics, sensed, guards.hulls)
        plan, period = ControllerPlan(), backend.control_period
        self._run = ProgramRun(program, self.signals, plan, period)
        self._actuation = Actuation(robot, self.signals, plan, period, guards)
        # Runner of the last episode, and whether its world continues in this one.
        self._before: Runner | None = None
        self._goes_on = False
        self._ticks, self._time = 0, 0.0
        self._observer = _SILENT

    def offer(self, program: CheckedProgram) -> None:
        """Go on as an edited program from the next change of state or episode, between ticks.

        The world, the references and the memories of objects stay. Observers are notified when
        the program or one that it uses is replaced.

        Args:
            program: Program without a schema, checked for the same robot.
        """
        self.signals.follow(resources_of(program))
        look_for = getattr(self._backend, "look_for", None)
        if look_for is not None:
            look_for(self.signals.vision.channels)
        self._run.offer(program, self._note_edit)

    def _note_edit(self, edit: EditTaken) -> None:
        self._actuation.drop_replaced()
        if edit.depth == 0:
            if edit.program.all_guards != self._program.all_guards:
                self._actuation.guard(edit.program.all_guards)
            self._program = edit.program
        self._observer.note_edit(edit)

    def run(
        self,
        stage: StageDocument,
        seed: int,
        context: str | None = None,
        observer: EpisodeObserver = _SILENT,
        *,
        undisturbed: bool = False,
    ) -> EpisodeResult:
        """Run one episode; the same seed gives the same episode.

        Args:
            stage: Stage of the episode.
            seed: Seed of all random numbers.
            context: Context of the stage; drawn if ``None``.
            observer: Observer of the episode, also if it is interrupted or fails.
            undisturbed: True if the experimenter leaves a continuing world as it is.

        Raises:
            BackendError: If the stage names an element that the backend or the robot lacks.
            EpisodeError: If a sensor gave NaN or infinity, or a controller cannot compute with its
                inputs.
            DeadlineError: If a tick took longer than the backend allows.

        The backend is halted before any exception leaves, including that of Ctrl-C.
        """
        ticks = self.ticks(stage, seed, context, observer, undisturbed=undisturbed)
        with closing(ticks):
            while True:
                try:
                    next(ticks)
                except StopIteration as ended:
                    result: EpisodeResult = ended.value
                    return result

    def ticks(
        self,
        stage: StageDocument,
        seed: int,
        context: str | None = None,
        observer: EpisodeObserver = _SILENT,
        *,
        undisturbed: bool = False,
    ) -> Generator[Tick, None, EpisodeResult]:
        """Run one episode tick by tick; the generator pauses between them; see ``run``.

        Closing the generator interrupts the episode.

        Yields:
            State after each tick but the last, before the world goes on.

        Returns:
            Outcome of the episode.
        """
        began = time.perf_counter()
        begun: _Begun | None = None
        self._observer = observer
        self._run.deactivate()  # which takes up an edit after the last change of state
        observer.begin(self._program, stage.name, seed)
        try:
            # The world and the program draw from separate streams, so that a program that draws
            # more samples meets the same world.
            world_rng, own_rng = (np.random.default_rng([seed, stream]) for stream in (0, 1))
            drawn = self._resume(stage, context, undisturbed=undisturbed)
            drawn = drawn or self._reset(stage, context, world_rng)
            passed: list[Transition] = []

            def note(transition: Transition) -> None:
                if transition.depth == 0:
                    passed.append(transition)
                observer.note_transition(transition)

            self._run.begin(own_rng, note, self._policy)
            self._ticks, self._time = 0, 0.0
            begun = _Begun(stage.name, drawn, seed, began, passed)
            late = yield from self._control(seed, observer)
        except BaseException as error:
            self._stop(error, begun, observer)
            raise
        result = self._result(begun, late)
        if not late:
            observer.note_end(result)
            return result
        lateness = DeadlineError(result)
        self._calls.halt(lateness)
        observer.note_end(result)
        raise lateness

    def _stop(self, cause: BaseException, begun: _Begun | None, observer: EpisodeObserver) -> None:
        """Halt the robot, and report a begun episode; an error while reporting becomes a note."""
        try:
            # The robot halts before anything else, because a report takes time and may fail.
            self._calls.halt(cause)
        finally:
            if begun is not None:
                self._end_early(cause, begun, observer)

    def _end_early(self, cause: BaseException, begun: _Begun, observer: EpisodeObserver) -> None:
        try:
            observer.note_end(self._result(begun, describe_stop(self._run, self._seconds, cause)))
        except Exception as failure:
            cause.add_note(f"the episode so far is not recorded: {failure}")

    @property
    def program(self) -> CheckedProgram:
        """Program that the runner runs."""
        return self._program

    @property
    def predicate(self) -> str:
        """Predicate of the program as an action: 0 running, 1 achieved, - ended without, X idle."""
        return self._run.predicate

    def take_over(self, before: Runner) -> None:
        """Continue from another runner of the same robot, on a stage whose world is persistent."""
        self._before = before

    def _resume(
        self, stage: StageDocument, context: str | None, *, undisturbed: bool
    ) -> str | None:
        """Begin an episode in the world of the last one, if the stage is persistent.

        References and tare stay, so that a held object stays held and its load measured.

        Returns:
            Name of the context; ``None`` if the world has to be reset.

        Raises:
            BackendError: If the backend's world cannot go on.
        """
        before = self._before
        if not stage.world.persistent or before is None:
            return None
        channels = self.signals.vision.channels
        drawn = self._calls.resume(stage, context, channels, undisturbed=undisturbed)
        if drawn is not None:
            self.signals.resume(before.signals)
            self._actuation.resume(before._actuation.reference)
            self._before, self._goes_on = self, True
        return drawn

    def _reset(self, stage: StageDocument, context: str | None, rng: np.random.Generator) -> str:
        """Begin an episode in a new world; return the name of its context."""
        drawn = self._calls.reset(stage, context, rng, self.signals.vision.channels)
        self.signals.reset()
        self._before, self._goes_on = self, False
        return drawn

    def _result(self, begun: _Begun, ending: str) -> EpisodeResult:
        """Return the outcome so far; an empty ending is replaced by the program's."""
        run, passed = self._run, begun.passed
        guards = (*self._actuation.load_guards.clauses, *self._actuation.clearance.clauses)
        stuck = () if ending else stuck_leads(run)
        causes = {lead.controller.name: self._actuation.cause(lead) for lead in stuck}
        # Only simulated cameras look again for colours that the program does not look for.
        look = getattr(self._backend, "colors_in_view", None)
        colors = look() if look is not None and not ending and lacks_color(run) else None
        return EpisodeResult(
            program=self._program.name,
            stage=begun.stage,
            context=begun.context,
            seed=begun.seed,
            rewarded=run.rewarded,
            predicates=("X" * len(self._program.members), *(t.next_state for t in passed)),
            actions=tuple(t.action for t in passed),
            ticks=self._ticks,
            sim_seconds=round(self._seconds, 6),
            wall_seconds=time.perf_counter() - begun.time,
            renderer=self._backend.renderer,
            ending=ending
            or describe(run, self._seconds, self._actuation.at_limits(), guards, causes, colors),
            outcome=run.outcome,
            guards=guards,
            far=tuple(causes),
            causes={name: str(cause or "unknown") for name, cause in causes.items()},
            halted=bool(ending),
            succeeded=run.succeeded and not ending,
        )

    @property
    def _seconds(self) -> float:
        """Time of the newest observation, s; ticks of a real robot may be late."""
        return self._time

    def _control(self, seed: int, observer: EpisodeObserver) -> Generator[Tick, None, str]:
        """Run the control ticks of an episode, and count them.

        Returns:
            Description of the lateness if the last tick was late; empty otherwise.
        """
        run, backend, calls = self._run, self._backend, self._calls
        # A tick observes, computes predicates and references, notifies the observer, and only then
        # applies the references and lets the world go on. The references of the last tick are not
        # applied. The deadline bounds the time of observation and computation, and excludes
        # observers and callers.
        for ticks in count():
            self._ticks = ticks
            began = self._clock()
            observation = calls.observe()
            self._time = observation.time
            self._advance(observation, seed, first=ticks == 0)
            taken = self._clock() - began
            tick = Tick(observation, self.signals, run, self._actuation)
            observer.note_tick(tick)
            if run.predicate != "0":
                break
            if backend.deadline is not None and taken > backend.deadline:
                return describe_lateness(run, observation.time, taken, backend.deadline)
            yield tick
            if run.predicate != "0":
                break  # the caller ended the program meanwhile
            calls.apply(self._actuation.reference)
            calls.step()
        return ""

    def _advance(self, observation: Observation, seed: int, *, first: bool) -> None:
        """Process an observation, and compute the next reference and predicates."""
        try:
            self.signals.is_awaited = self._backend.deadline is None
            self.signals.update(observation)
            if first:
                # In a continued world the references go on, too. Under load they differ from the
                # measured positions, and a grasp would lose its force.
                if not self._goes_on:
                    self._actuation.reset(observation.positions)
                self._run.activate()
            self._actuation.move(self._run.active())
            self._run.advance()
        except (SensorError, SignalError, ConvergenceError) as error:
            raise EpisodeError(f"seed {seed}, {observation.time:.2f} s: {error}") from error

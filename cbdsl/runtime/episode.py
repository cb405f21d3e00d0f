"""One episode: a program, a backend and a stage, from reset to the end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

import numpy as np

from cbdsl.backends.backend import Backend
from cbdsl.control.multigrid import ConvergenceError
from cbdsl.control.plan import ControllerPlan
from cbdsl.control.signal import SignalError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.errors.errors import UsageError
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.ending import describe, describe_lateness
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import SensorError, Signals
from cbdsl.types.policy import Policy
from cbdsl.types.resource import Resource


class EpisodeError(UsageError):
    """An episode cannot go on; the message says which, when and why."""


class DeadlineError(EpisodeError):
    """A control tick took longer than its backend allows.

    Attributes:
        result: of the episode, whose ending is the message.
    """

    def __init__(self, result: EpisodeResult) -> None:
        super().__init__(f"seed {result.seed}: {result.ending}")
        self.result = result


@dataclass(frozen=True)
class EpisodeResult:
    """Outcome of an episode.

    Attributes:
        program, stage, context, seed: what was run.
        rewarded: whether the program earned its reward.
        predicates: the states that were passed, from all X to the last.
        actions: the actions between them.
        ticks: control ticks.
        sim_seconds, wall_seconds: how long it took.
        renderer: what made the images.
        ending: how it ended and why, as a sentence.
    """

    program: str
    stage: str
    context: str
    seed: int
    rewarded: bool
    predicates: tuple[str, ...]
    actions: tuple[str, ...]
    ticks: int
    sim_seconds: float
    wall_seconds: float
    renderer: str
    ending: str


class Tick(NamedTuple):
    """State of an episode after a control tick, for recorders."""

    observation: Observation
    signals: Signals
    run: ProgramRun
    actuation: Actuation


TickListener = Callable[[Tick], None]
TransitionListener = Callable[[Transition], None]


class Runner:
    """Runs episodes of one program with one backend.

    Args:
        robot: the robot that the program was checked against.
        kinematics: of the same robot.
        program: what to run.
        backend: where.
        policy: chooses the actions instead of the program's written policy.
        clock: the wall time that deadlines are held against, s.
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
    ) -> None:
        self._program = program
        self._clock = clock
        self._backend = backend
        self._policy = policy
        self.signals = Signals(robot, kinematics, resources_of(program))
        plan, period = ControllerPlan(), backend.control_period
        self._run = ProgramRun(program, self.signals, plan, period)
        self._actuation = Actuation(robot, self.signals, plan, period)

    def run(
        self,
        stage: StageDocument,
        seed: int,
        context: str | None = None,
        on_transition: TransitionListener = lambda transition: None,
        on_tick: TickListener | None = None,
    ) -> EpisodeResult:
        """Run one episode; the same seed gives the same episode.

        Raises:
            BackendError: the stage names something that it or the robot does not have.
            EpisodeError: a sensor gave NaN or infinity, or a controller cannot compute with what
                it was given.
            DeadlineError: a tick took longer than the backend allows.

        Whatever is raised, Ctrl-C too, the backend is halted before.
        """
        began = time.perf_counter()
        world_rng, own_rng = (np.random.default_rng([seed, stream]) for stream in (0, 1))
        drawn = self._backend.reset(stage, context, world_rng, self.signals.vision.channels)
        self.signals.reset()
        passed: list[Transition] = []

        def note(transition: Transition) -> None:
            if transition.depth == 0:
                passed.append(transition)
            on_transition(transition)

        self._run.begin(own_rng, note, self._policy)
        try:
            ticks, late = self._control(seed, on_tick)
        except BaseException:
            self._backend.halt()
            raise
        seconds, run = ticks * self._backend.control_period, self._run
        result = EpisodeResult(
            program=self._program.name,
            stage=stage.name,
            context=drawn,
            seed=seed,
            rewarded=run.rewarded,
            predicates=("X" * len(self._program.members), *(t.next_state for t in passed)),
            actions=tuple(t.action for t in passed),
            ticks=ticks,
            sim_seconds=round(seconds, 6),
            wall_seconds=time.perf_counter() - began,
            renderer=self._backend.renderer,
            ending=late or describe(run, seconds, self._actuation.at_limits()),
        )
        if late:
            raise DeadlineError(result)
        return result

    def _control(self, seed: int, on_tick: TickListener | None) -> tuple[int, str]:
        """Run the control ticks of an episode.

        Returns:
            How many there were, and why the episode ends if the last one was late.
        """
        run, backend = self._run, self._backend
        for ticks in count():
            began = self._clock()
            observation = backend.observe()
            self._advance(observation, seed, first=ticks == 0)
            taken = self._clock() - began
            if on_tick is not None:
                on_tick(Tick(observation, self.signals, run, self._actuation))
            if run.predicate != "0":
                break
            if backend.deadline is not None and taken > backend.deadline:
                backend.halt()
                return ticks, describe_lateness(run, observation.time, taken, backend.deadline)
            backend.apply(self._actuation.reference)
            backend.step()
        return ticks, ""

    def _advance(self, observation: Observation, seed: int, *, first: bool) -> None:
        """Take in an observation, and find the next reference and predicates."""
        try:
            self.signals.update(observation)
            if first:
                self._actuation.reset(observation.positions)
                self._run.activate()
            self._actuation.move(self._run.active())
            self._run.advance()
        except (SensorError, SignalError, ConvergenceError) as error:
            raise EpisodeError(f"seed {seed}, {observation.time:.2f} s: {error}") from error


def resources_of(program: CheckedProgram) -> Sequence[Resource]:
    """Every resource that a program and the programs it uses can read."""
    resources: dict[Resource, None] = {}
    compositions = [program.background, *(action.composition for action in program.actions)]
    for composition in compositions:
        for primitive in composition.primitives if composition else ():
            for controller in primitive.controllers:
                resources.update(dict.fromkeys(controller.resources))
    for action in program.actions:
        if action.program is not None:
            resources.update(dict.fromkeys(resources_of(action.program)))
    return list(resources)

"""One episode: a program, a backend and a stage, from reset to the end."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
from cbdsl.runtime.ending import describe
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import SensorError, Signals
from cbdsl.types.policy import Policy
from cbdsl.types.resource import Resource


class EpisodeError(UsageError):
    """An episode cannot go on; the message says which, when and why."""


@dataclass(frozen=True)
class EpisodeResult:
    """What came of an episode.

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
    """What a recorder may look at after each control tick."""

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
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        program: CheckedProgram,
        backend: Backend,
        policy: Policy | None = None,
    ) -> None:
        self._program = program
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
                it was given; nothing is moved any more.
        """
        began = time.perf_counter()
        world_rng, own_rng = (np.random.default_rng([seed, stream]) for stream in (0, 1))
        drawn = self._backend.reset(stage, context, world_rng, self.signals.vision.channels)
        period = self._backend.control_period
        self.signals.reset()
        passed: list[Transition] = []

        def note(transition: Transition) -> None:
            if transition.depth == 0:
                passed.append(transition)
            on_transition(transition)

        run, actuation = self._run, self._actuation
        run.begin(own_rng, note, self._policy)
        ticks = 0
        while True:
            observation = self._backend.observe()
            try:
                self.signals.update(observation)
                if ticks == 0:
                    actuation.reset(observation.positions)
                    run.activate()
                actuation.move(run.active())
                run.advance()
            except (SensorError, SignalError, ConvergenceError) as error:
                raise EpisodeError(f"seed {seed}, {observation.time:.2f} s: {error}") from error
            if on_tick is not None:
                on_tick(Tick(observation, self.signals, run, actuation))
            if run.predicate != "0":
                break
            ticks += 1
            self._backend.apply(actuation.reference)
            self._backend.step()
        return EpisodeResult(
            program=self._program.name,
            stage=stage.name,
            context=drawn,
            seed=seed,
            rewarded=run.rewarded,
            predicates=("X" * len(self._program.members), *(t.next_state for t in passed)),
            actions=tuple(t.action for t in passed),
            ticks=ticks,
            sim_seconds=round(ticks * period, 6),
            wall_seconds=time.perf_counter() - began,
            renderer=self._backend.renderer,
            ending=describe(run, ticks * period, actuation.at_limits()),
        )


def resources_of(program: CheckedProgram) -> Sequence[Resource]:
    """Every resource that a program and the programs it uses can read."""
    found: dict[Resource, None] = {}
    compositions = [program.background, *(action.composition for action in program.actions)]
    for composition in compositions:
        for primitive in composition.primitives if composition else ():
            for controller in primitive.controllers:
                found.update(dict.fromkeys(controller.resources))
    for action in program.actions:
        if action.program is not None:
            found.update(dict.fromkeys(resources_of(action.program)))
    return list(found)

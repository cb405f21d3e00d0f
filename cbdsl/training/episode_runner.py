"""Runners of single episodes of a stage on a backend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from cbdsl.backends.backend import Backend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeObserver, EpisodeObservers
from cbdsl.runtime.policies.policy import Policy
from cbdsl.runtime.tick import Tick
from cbdsl.training.impedance_gauge import ImpedanceGauge
from cbdsl.types.source_record import owner_of, record_of


class EpisodeRunner(Protocol):
    """Runner of one episode after another."""

    def run(
        self, program: CheckedProgram, policy: Policy, seed: int, see: Callable[[Transition], None]
    ) -> Experience:
        """Run an episode.

        Args:
            program: Program to run.
            policy: Policy that chooses its actions.
            seed: Seed; equal seeds give equal episodes if the policy chooses equally.
            see: Listener that receives each transition of the program before the next action is
                chosen.
        """
        ...


class BackendEpisodeRunner:
    """Runner of episodes of a stage on a backend.

    Args:
        robot: Robot that programs were checked against.
        kinematics: Kinematics of the same robot.
        backend: Backend that embodies the robot.
        stage: Training context.
        observer: Observer of the episodes.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        backend: Backend,
        stage: StageDocument,
        observer: EpisodeObserver | None = None,
    ) -> None:
        self._robot, self._kinematics = robot, kinematics
        self._backend, self._stage = backend, stage
        self._observer = observer or EpisodeObserver()
        self._last: tuple[CheckedProgram, Policy, Runner] | None = None

    def run(
        self, program: CheckedProgram, policy: Policy, seed: int, see: Callable[[Transition], None]
    ) -> Experience:
        """Run an episode; see ``EpisodeRunner.run``.

        Raises:
            BackendError, EpisodeError: Errors of ``Runner.run``.
        """
        learning = _LearnedEpisode(see)
        gauge, runner = ImpedanceGauge(program), self._runner(program, policy)
        observer = EpisodeObservers(self._observer, learning, gauge)
        result = runner.run(self._stage, seed, observer=observer)
        return Experience(
            context=result.context,
            seed=seed,
            transitions=tuple(learning.transitions),
            rewarded=learning.rewarded,
            ticks=result.ticks,
            sim_seconds=result.sim_seconds,
            wall_seconds=result.wall_seconds,
            profile=gauge.finish(runner.signals),
            relation=self._stage.contexts[result.context].relation or "",
        )

    def _runner(self, program: CheckedProgram, policy: Policy) -> Runner:
        """Return the runner of the last episode if program and policy are the same."""
        if self._last is not None:
            before, chooser, runner = self._last
            if before is program and chooser is policy:
                return runner
        runner = Runner(self._robot, self._kinematics, program, self._backend, policy)
        if self._last is not None:
            # On a persistent stage, the world of the last episode goes on under the new runner.
            runner.take_over(self._last[2])
        self._last = program, policy, runner
        return runner


class _LearnedEpisode(EpisodeObserver):
    """Observer that keeps the parts of an episode that a learner uses.

    Args:
        see: Listener that receives each transition of the program itself.

    Attributes:
        transitions: Transitions of the program itself.
        rewarded: Configuration of each effector that earned the reward, rad.
    """

    def __init__(self, see: Callable[[Transition], None]) -> None:
        self._see = see
        self.transitions: list[Transition] = []
        self.rewarded: dict[str, tuple[float, ...]] = {}

    def note_transition(self, transition: Transition) -> None:
        """Keep a transition of the program itself."""
        if transition.depth == 0:
            self.transitions.append(transition)
            self._see(transition)

    def note_tick(self, tick: Tick) -> None:
        """Keep the configurations that earned a reward in this tick."""
        # These samples are of Pr(tau | sigma, reward) (line 19 of Algorithm 1). A reward ends a
        # learner's episode, so the last transition is the rewarded one.
        program = tick.run.program
        for member in self.transitions[-1].rewarding if tick.run.rewarded else ():
            effector = moved(program.primitives[member].lead)
            angles = tick.observation.positions[tick.signals.joints.of(effector)]
            self.rewarded[effector] = tuple(float(angle) for angle in angles)


def moved(controller: Controller) -> str:
    """Return the effector or group whose joints a controller moves."""
    source = controller.effector.source
    assert record_of(source).moves, "an effector has joints"
    return owner_of(source)

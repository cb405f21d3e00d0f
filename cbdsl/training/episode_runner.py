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
from cbdsl.runtime.episode import EpisodeResult, Runner, Tick
from cbdsl.runtime.episode_watcher import EpisodeWatcher
from cbdsl.types.policy import Policy
from cbdsl.types.resource import Centroid, EffectorConfiguration, Separation, Tip


class EpisodeRunner(Protocol):
    """Runner of one episode after another."""

    def run(
        self,
        program: CheckedProgram,
        policy: Policy,
        seed: int,
        see: Callable[[Transition], None],
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
        watcher: Observer of the episodes, if any.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        backend: Backend,
        stage: StageDocument,
        watcher: EpisodeWatcher | None = None,
    ) -> None:
        self._robot, self._kinematics = robot, kinematics
        self._backend, self._stage, self._watcher = backend, stage, watcher
        self._last: tuple[CheckedProgram, Policy, Runner] | None = None

    def run(
        self,
        program: CheckedProgram,
        policy: Policy,
        seed: int,
        see: Callable[[Transition], None],
    ) -> Experience:
        """Run an episode; see ``EpisodeRunner.run``.

        Raises:
            BackendError, EpisodeError: Errors of ``Runner.run``.
        """
        runner, watcher = self._runner(program, policy), self._watcher
        transitions: list[Transition] = []
        rewarded: dict[str, tuple[float, ...]] = {}

        def on_transition(transition: Transition) -> None:
            if watcher is not None:
                watcher.note_transition(transition)
            if transition.depth == 0:
                transitions.append(transition)
                see(transition)

        def on_tick(tick: Tick) -> None:
            for member in transitions[-1].rewarding if tick.run.rewarded else ():
                effector = moved(program.primitives[member].lead)
                angles = tick.observation.positions[tick.signals.joints.of(effector)]
                rewarded[effector] = tuple(float(angle) for angle in angles)
            if watcher is not None:
                watcher.note_tick(tick)

        def on_end(result: EpisodeResult) -> None:
            if watcher is not None:
                watcher.note_end(result)

        if watcher is not None:
            watcher.begin(program, self._stage.name, seed)
        result = runner.run(
            self._stage, seed, on_transition=on_transition, on_tick=on_tick, on_end=on_end
        )
        return Experience(
            context=result.context,
            seed=seed,
            transitions=tuple(transitions),
            rewarded=rewarded,
            ticks=result.ticks,
            sim_seconds=result.sim_seconds,
            wall_seconds=result.wall_seconds,
        )

    def _runner(self, program: CheckedProgram, policy: Policy) -> Runner:
        """Return the runner of the last episode if program and policy are the same."""
        if self._last is not None:
            before, chooser, runner = self._last
            if before is program and chooser is policy:
                return runner
        runner = Runner(self._robot, self._kinematics, program, self._backend, policy)
        if self._last is not None:
            runner.take_over(self._last[2])
        self._last = program, policy, runner
        return runner


def moved(controller: Controller) -> str:
    """Return the effector or group whose joints a controller moves."""
    source = controller.effector.source
    if isinstance(source, (Centroid, Separation)):
        return source.group
    assert isinstance(source, (EffectorConfiguration, Tip)), "only these can be moved"
    return source.effector

"""Open robots: on a backend, kept open for any number of episodes."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.api.shared_body import BodyEpisode, SharedBody

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.program.transition import Transition
    from cbdsl.runtime.episode import Runner
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.policies.policy import Policy
    from cbdsl.runtime.tick import Tick


class OpenRobot:
    """Robot on a backend that runs its program.

    Args:
        request: Program with its robot and its stage.
        backend: Backend, owned by the caller.
        kinematics: Kinematics of the robot.

    Attributes:
        request: Program with its robot and its stage.
        kinematics: Kinematics of the robot.
    """

    def __init__(self, request: RunRequest, backend: Backend, kinematics: Kinematics) -> None:
        self.request, self.kinematics = request, kinematics
        self._body = SharedBody(backend)
        # Runners of this program, each with the policy that chooses its actions.
        self._runners: list[tuple[Policy | None, Runner]] = []

    @property
    def backend(self) -> Backend:
        """Backend of the robot.

        Raises:
            UsageError: The robot is closed.
        """
        return self._body.backend

    def close(self) -> None:
        """Interrupt the running episode; the body cannot run another one."""
        self._body.close()

    def interrupt(self, reason: str = "it was interrupted") -> None:
        """Interrupt the running episode of this body, if any, and halt the robot.

        Args:
            reason: RestCause, as a clause, for the error of the interrupted episode.
        """
        self._body.interrupt(reason)

    def with_program(self, program: str | Path | RunRequest) -> OpenRobot:
        """Return the same body with another program, on the same stage.

        On a stage with a persistent world it continues from the final state of the other program.

        Raises:
            DiagnosticsError: A document has errors.
            UsageError: The program is another robot's, or cannot be loaded, or the robot is
                closed.
        """
        from dataclasses import replace

        from cbdsl.api.load import load
        from cbdsl.api.requests.run_request import RunRequest
        from cbdsl.diagnostics.errors import UsageError

        self._body.require_open()
        other = program if isinstance(program, RunRequest) else load(program)
        own = self.request
        if other.robot != own.robot:
            names = f"{other.program.name} is for '{other.robot.name}'"
            raise UsageError(f"{names}, and this robot is '{own.robot.name}'")
        shared = OpenRobot(replace(other, stage=own.stage), self.backend, self.kinematics)
        # The constructor has made a second body for the same backend. One body makes the programs
        # exclude each other.
        shared._body = self._body
        return shared

    def runner(self, policy: Policy | None = None) -> Runner:
        """Return the runner of the program's episodes under a policy, by default its own."""
        from cbdsl.runtime.episode import Runner

        for chooser, runner in self._runners:
            # Policies are compared by identity: equal ones may have random draws or decisions of
            # their own.
            if chooser is policy:
                return runner
        request = self.request
        made = Runner(request.robot, self.kinematics, request.program, self.backend, policy)
        self._runners.append((policy, made))
        return made

    def run(
        self,
        seed: int = 0,
        *,
        context: str | None = None,
        on_transition: Callable[[Transition], None] | None = None,
        on_tick: Callable[[Tick], object] | None = None,
    ) -> EpisodeResult:
        """Run one episode; equal seeds give equal episodes.

        Args:
            seed: Seed of all random draws, from 0.
            context: Context of the stage; drawn by share if ``None``.
            on_transition: Function called with each change of state.
            on_tick: Function called at each control tick, with the observation and the signals.

        Raises:
            UsageError: The stage has no such context, the episode cannot go on, another one runs
                on this body, or the robot is closed.
        """
        from cbdsl.diagnostics.errors import UsageError

        stage = self.request.stage
        if context is not None and context not in stage.contexts:
            what = f"context of stage '{stage.name}'"
            raise UsageError.unknown(what, context, stage.contexts)
        episode = self._episode(None, seed, context, on_transition, on_tick)
        # The body is free again after an exception between two ticks, such as Ctrl-C.
        with closing(episode):
            # A `for` loop would lose the result, which is the value of `StopIteration`.
            while True:
                try:
                    next(episode)
                except StopIteration as ended:
                    result: EpisodeResult = ended.value
                    return result

    def ticks(
        self,
        seed: int = 0,
        *,
        policy: Policy | None = None,
        context: str | None = None,
        on_transition: Callable[[Transition], None] | None = None,
    ) -> Generator[Tick, None, EpisodeResult]:
        """Run one episode control tick by control tick; see ``Runner.ticks``.

        It begins with the first tick, and raises ``UsageError`` if another episode runs on this
        body by then, or if the robot is closed.
        """
        return self._episode(policy, seed, context, on_transition, None)

    def _episode(
        self,
        policy: Policy | None,
        seed: int,
        context: str | None,
        on_transition: Callable[[Transition], None] | None,
        on_tick: Callable[[Tick], object] | None,
    ) -> BodyEpisode:
        from cbdsl.runtime.episode_observer import EpisodeListeners

        listeners = EpisodeListeners(on_transition, on_tick)

        # Evaluated at the first tick, not when the generator is made: another program may run in
        # between.
        def begin() -> Generator[Tick, None, EpisodeResult]:
            stage, goes_on = self.request.stage, self._is_taken_over()
            runner = self._next(policy)
            return runner.ticks(stage, seed, context, listeners, undisturbed=goes_on)

        self._body.require_open()
        return BodyEpisode(self._body, self.request.program.name, begin)

    def _is_taken_over(self) -> bool:
        """Return whether another program's episode continues, undisturbed by the experimenter."""
        own = [runner for _, runner in self._runners]
        return self._body.last is not None and self._body.last not in own

    def _next(self, policy: Policy | None = None) -> Runner:
        """Return the runner of the next episode, which continues where the last one ended."""
        runner = self.runner(policy)
        last = self._body.last
        if last is not None and last is not runner:
            runner.take_over(last)
        self._body.last = runner
        return runner


@contextmanager
def open_robot(
    program: str | Path | RunRequest,
    *,
    backend: str | None = None,
    cameras: str | None = None,
    gui: bool = False,
    persistent: bool = False,
) -> Iterator[OpenRobot]:
    """Open the robot of a program on a backend, and close it in the end.

    Args:
        program: Result of ``load``, or a file or name for it.
        backend: ``bullet`` or ``mujoco`` (physics), ``kinematic``, or the name of another package's
            backend; the first installed one if ``None``.
        cameras: ``rendered`` or ``ideal``; the backend's own choice if ``None``.
        gui: True to open the simulator's window.
        persistent: True to keep the world between episodes, regardless of the stage.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed, or does not fit.
    """
    from cbdsl.api.load import load
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import embody
    from cbdsl.backends.backend_calls import closing_backend
    from cbdsl.backends.engines import default_engine
    from cbdsl.kinematics.kinematics import Kinematics

    request = program if isinstance(program, RunRequest) else load(program)
    if persistent:
        request = _persistent(request)
    chosen = default_engine() if backend is None else backend
    simulated = embody(chosen, request.robot, request.urdf, gui=gui, cameras=cameras)
    with closing_backend(simulated):
        robot = OpenRobot(request, simulated, Kinematics(request.robot, request.urdf))
        with closing(robot):
            yield robot


def _persistent(request: RunRequest) -> RunRequest:
    """Return the request with a persistent world on its stage."""
    from dataclasses import replace

    world = request.stage.world.model_copy(update={"persistent": True})
    return replace(request, stage=request.stage.model_copy(update={"world": world}))

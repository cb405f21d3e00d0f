"""Connection: the open links to a robot, and the supervisor that hears them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from cbdsl.extend.backend import BackendError, RobotDocument
from cbdsl.extend.driver import Command, DriverLink, Endpoint, Sample, Setup, StagingLink
from cbdsl_drive.clock import Clock
from cbdsl_drive.safety_supervisor import SafetySupervisor
from cbdsl_drive.survey import survey_problems

Opener = Callable[[RobotDocument, str | None], Sequence[DriverLink]]

# Longest wait until a robot is ready, s; then every reason against it is reported.
_PATIENCE = 5.0
# Longest wait for a description that a publisher repeats, s.
_DESCRIBED = 10.0
# Time between two polls while waiting, s; after longer ones queued messages are old.
_PAUSE, _STARVED = 5e-4, 0.02
# Time between two judgements of readiness, s.
_WINDOW = 0.1
# Longest time until a stage is set up, and time between two requests for it, s.
_SET_UP, _REPEATED = 30.0, 0.5


class Connection:
    """Links to all parts of a robot.

    Args:
        robot: Robot with drivers.
        supervisor: State machine that gets all samples.
        opener: Opens the drivers.
        clock: Times of this computer.

    Attributes:
        interface: Network interface; loopback only if ``None``.
    """

    def __init__(
        self, robot: RobotDocument, supervisor: SafetySupervisor, opener: Opener, clock: Clock
    ) -> None:
        self._robot, self._supervisor, self._opener = robot, supervisor, opener
        self._clock = clock
        self._links: list[DriverLink] = []
        self.interface: str | None = None

    def open(self) -> None:
        """Open the drivers, unless they are open.

        Raises:
            BackendError: They cannot be opened.
        """
        if not self._links:
            self._links.extend(self._opener(self._robot, self.interface))

    def claim(self) -> None:
        """Appear as the robot's commander."""
        for link in self._links:
            link.claim()

    def send(self, name: str, command: Command) -> None:
        """Send references to a driver's controller."""
        for link in self._links:
            link.send(name, command)

    def rest(self) -> None:
        """Say that no references follow until an episode begins anew."""
        for link in self._links:
            link.rest()

    def close(self) -> None:
        """Close all links."""
        for link in self._links:
            link.close()
        self._links.clear()

    def examine(self, seconds: float) -> list[Endpoint]:
        """Listen for a while, and for a description; return the streams of all drivers."""
        self.open()
        self.listen(seconds)
        until = self._clock.monotonic() + _DESCRIBED
        while self._awaits_description() and self._clock.monotonic() < until:
            self.listen(_WINDOW)
        return self._surveyed()

    def _surveyed(self) -> list[Endpoint]:
        return [endpoint for link in self._links for endpoint in link.survey()]

    def obstacles(self) -> list[str]:
        """Return every reason against ``ready``, one sentence each."""
        problems = survey_problems(self._surveyed())
        return self._supervisor.obstacles(problems, self._clock.monotonic())

    def await_stage(self, setup: Setup) -> None:
        """Wait until the simulation that serves the robot, if any, has set up the stage.

        Raises:
            BackendError: It refuses, or does not answer.
        """
        clock, until, asked = self._clock, self._clock.monotonic() + _SET_UP, -np.inf
        waiting = [link for link in self._links if isinstance(link, StagingLink) and link.stages]
        for link in waiting:
            answer: str | None = None
            while answer is None:
                if clock.monotonic() > until:
                    raise BackendError(
                        f"the stage is not set up: no answer for {_SET_UP:.0f} s; another program "
                        "may command the robot"
                    )
                if clock.monotonic() - asked > _REPEATED:
                    link.ask(setup)
                    asked = clock.monotonic()
                clock.sleep(_PAUSE)
                answer = link.answer()
            if answer:
                raise BackendError(f"the stage is not set up: {answer}")

    def drain(self) -> None:
        """Discard queued samples except for those without a stamp, which come once."""
        now, wall = self._clock.monotonic(), self._clock.wall()
        for sample in self._polled():
            if not hasattr(sample, "stamp"):
                self._supervisor.note(sample, now, wall)

    def await_ready(self) -> None:
        """Wait until no reason against ``ready`` is left.

        Raises:
            BackendError: A reason is left after the longest wait.
        """
        began = self._clock.monotonic()
        obstacles, patience = ["nothing was heard"], _PATIENCE
        while self._clock.monotonic() - began < patience:
            self._supervisor.forget_mismatches()
            self.listen(_WINDOW)
            obstacles = self.obstacles()
            if not obstacles:
                return
            patience = _DESCRIBED if self._awaits_description() else _PATIENCE
        lines = "".join(f"\n- {obstacle}" for obstacle in obstacles)
        raise BackendError(f"robot '{self._robot.name}' is not ready:{lines}")

    def _awaits_description(self) -> bool:
        """Return whether a publisher of the robot's description has not sent it so far."""
        return self._supervisor.is_undescribed and any(
            endpoint.role == "description" and endpoint.peers > 0 for endpoint in self._surveyed()
        )

    def listen(self, seconds: float) -> None:
        """Process samples for a while; discard samples that queued while this process slept."""
        clock = self._clock
        last, until = -np.inf, clock.monotonic() + seconds
        while (now := clock.monotonic()) < until:
            if now - last > _STARVED:
                self.drain()
            else:
                self.gather()
            last = now
            clock.sleep(_PAUSE)

    def _polled(self) -> Iterator[Sample]:
        for link in self._links:
            yield from link.poll()

    def gather(self) -> None:
        """Process all samples that arrived."""
        for sample in self._polled():
            self._supervisor.note(sample, self._clock.monotonic(), self._clock.wall())

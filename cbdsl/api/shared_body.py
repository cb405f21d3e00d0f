"""Shared body of an open robot: one episode at a time, until it is closed."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from types import TracebackType
from typing import TYPE_CHECKING, cast
from weakref import ref

if TYPE_CHECKING:
    from cbdsl.backends.backend import Backend
    from cbdsl.runtime.episode import Runner
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.tick import Tick


class SharedBody:
    """Body that programs share.

    Args:
        backend: Backend of the robot.

    Attributes:
        last: Runner of the last episode, of any program of the body.
    """

    def __init__(self, backend: Backend) -> None:
        self._backend, self._is_open = backend, True
        # A weak reference: an abandoned episode counts as ended.
        self._running: ref[BodyEpisode] | None = None
        self.last: Runner | None = None

    @property
    def backend(self) -> Backend:
        """Backend of the robot.

        Raises:
            UsageError: The robot is closed.
        """
        self.require_open()
        return self._backend

    def require_open(self) -> None:
        """Require that the robot is open.

        Raises:
            UsageError: The robot is closed.
        """
        from cbdsl.diagnostics.errors import UsageError

        if not self._is_open:
            raise UsageError("this robot is closed; open it again with open_robot")

    def begin(self, episode: BodyEpisode) -> None:
        """Begin an episode.

        Raises:
            UsageError: The robot is closed, or another episode runs on it.
        """
        from cbdsl.diagnostics.errors import UsageError

        self.require_open()
        running = self._episode
        if running is not None:
            raise UsageError(
                f"'{episode.program}' cannot begin while '{running.program}' runs on the same "
                "robot: end that first, or compose both in one program, as in 'a ◁ b'"
            )
        self._running = ref(episode)

    def end(self, episode: BodyEpisode) -> None:
        """Note that an episode has ended."""
        if self._episode is episode:
            self._running = None

    def interrupt(self, reason: str) -> None:
        """Interrupt the episode that runs, if any, and halt the robot.

        Args:
            reason: RestCause, as a clause, for the error of the interrupted episode.
        """
        running = self._episode
        if running is not None:
            running.interrupt(reason)

    @property
    def _episode(self) -> BodyEpisode | None:
        """Episode that runs."""
        return None if self._running is None else self._running()

    def close(self) -> None:
        """Interrupt the running episode; the body cannot run another one."""
        self._is_open = False
        self.interrupt("its robot was closed")


# An episode is a generator that owns the body from its first tick to its end. It begins late,
# because a generator that is never advanced must not block the body. It ends in four ways: by its
# outcome, an exception, `close`, or an interruption by another program. The last one has two cases.
# Between ticks, the episode is closed immediately. During a tick, as from a callback, Python
# forbids to close a running generator; the next tick raises the reason instead.
class BodyEpisode(Generator["Tick", None, "EpisodeResult"]):
    """Episode of a program on a body, control tick by control tick.

    It begins with the first tick. Closing it interrupts the episode.

    Args:
        body: The body.
        program: Name of the program.
        begin: Function that begins the episode.

    Attributes:
        program: As given.
    """

    def __init__(
        self,
        body: SharedBody,
        program: str,
        begin: Callable[[], Generator[Tick, None, EpisodeResult]],
    ) -> None:
        self._body, self.program, self._begin = body, program, begin
        self._ticks: Generator[Tick, None, EpisodeResult] | None = None
        self._interruption, self._is_advancing = "", False

    def send(self, value: None) -> Tick:
        """Run a control tick.

        Raises:
            StopIteration: The episode has ended; its value is the outcome.
            UsageError: The episode was interrupted, or cannot begin.
        """
        from cbdsl.diagnostics.errors import UsageError

        if self._interruption:
            self.close()
            raise UsageError(f"'{self.program}' cannot go on: {self._interruption}")
        if self._ticks is None:
            # The body is claimed first: no other runner may be prepared while an episode runs.
            self._body.begin(self)
        self._is_advancing = True
        try:
            if self._ticks is None:
                self._ticks = self._begin()
            return next(self._ticks)
        # The regular end is an exception, too: `StopIteration` with the outcome.
        except BaseException:
            self._body.end(self)
            raise
        finally:
            self._is_advancing = False

    def throw(
        self,
        kind: type[BaseException] | BaseException,
        value: BaseException | object = None,
        trace: TracebackType | None = None,
    ) -> Tick:
        """End the episode with an exception."""
        error = kind if isinstance(kind, BaseException) else kind()
        # An episode that never began has no generator to throw into.
        if self._ticks is None:
            self._ticks = _ended()
        try:
            return self._ticks.throw(error)
        finally:
            self._body.end(self)

    def interrupt(self, reason: str) -> None:
        """Interrupt the episode, after the tick that runs; its next tick raises the reason."""
        self._interruption = reason
        if not self._is_advancing:
            self.close()


def _ended() -> Generator[Tick, None, EpisodeResult]:
    """Return an episode that never began."""
    empty: Iterator[Tick] = iter(())
    return cast("Generator[Tick, None, EpisodeResult]", (tick for tick in empty))

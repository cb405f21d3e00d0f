"""Transport of a watched run: paused, tick by tick, or at a speed, and requests between ticks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from threading import Condition
from typing import Any

from cbdsl.runtime.episode_observer import ReturnRequest

# A run that is late by more than this continues at its speed without catching up, s.
_LATE = 0.25
# Timeout of a request that waits for a tick, s.
_PATIENCE = 3.0


class IdleError(Exception):
    """Error of a request during which no episode runs."""


class Transport:
    """Pace of ticks, set from any thread.

    Args:
        speed: Simulated seconds per second; infinite for the maximum speed.
        clock: Function that returns the wall time, s.

    Attributes:
        between: Function called in each tick, and about once a second while ticks are paused.
    """

    def __init__(self, speed: float = 1.0, clock: Callable[[], float] = time.perf_counter) -> None:
        self._changed = Condition()
        self._clock = clock
        self._speed = speed
        self._paused = self._released = False
        self._steps = 0
        self._asked: list[tuple[Callable[[], Any], Future[Any]]] = []
        # Simulated times of the last tick, of the requested return, and of its pause.
        self.now, self._return, self._goal = 0.0, math.nan, math.nan
        # Wall time at which simulated time 0 was, or would have been at this speed.
        self._origin: float | None = None
        self.between: Callable[[], None] = lambda: None

    @property
    def paused(self) -> bool:
        """True if ticks are paused."""
        return self._paused

    @property
    def shown_speed(self) -> float | None:
        """Simulated seconds per second; ``None`` for the maximum speed."""
        return self._speed if math.isfinite(self._speed) else None

    def begin(self) -> None:
        """Begin an episode."""
        with self._changed:
            self._origin = None

    def pause(self) -> None:
        """Pause the ticks."""
        with self._changed:
            self._paused, self._steps = not self._released, 0
            self._changed.notify_all()

    def go_on(self) -> None:
        """Let ticks pass again."""
        with self._changed:
            self._paused, self._origin = False, None
            self._changed.notify_all()

    def step(self, ticks: int = 1) -> None:
        """Let some ticks pass, and pause."""
        with self._changed:
            self._paused, self._steps = not self._released, ticks
            self._changed.notify_all()

    def hasten(self, speed: float) -> None:
        """Change the speed."""
        with self._changed:
            self._speed, self._origin = speed, None
            self._changed.notify_all()

    def release(self) -> None:
        """Release the pause for good, because no page is left that could continue."""
        with self._changed:
            self._released, self._paused = True, False
            self._changed.notify_all()

    def go_back(self, time: float) -> None:
        """Ask the run to return to an earlier time."""
        with self._changed:
            self._return = time
            self._changed.notify_all()

    def take_return(self, patience: float = 0.0) -> float | None:
        """Return the requested time, s, once, after at most ``patience``, s."""
        with self._changed:
            if not self._changed.wait_for(lambda: not math.isnan(self._return), patience):
                return None
            time, self._return = self._return, math.nan
            return time

    def run_to(self, time: float) -> None:
        """Let the next episode pass at the maximum speed up to a time, and pause there."""
        self._goal = time

    @property
    def is_returning(self) -> bool:
        """True until the time of the return."""
        return not math.isnan(self._goal)

    def ask(self, do: Callable[[], Any]) -> Any:
        """Execute a function between two ticks, in the thread of the ticks.

        Raises:
            IdleError: No tick passed.
            Exception: Any exception of ``do``.
        """
        future: Future[Any] = Future()
        with self._changed:
            self._asked.append((do, future))
            self._changed.notify_all()
        try:
            return future.result(_PATIENCE)
        except TimeoutError as error:
            if future.cancel():
                raise IdleError("no episode runs") from error
            # A tick has begun to execute the function. A refusal would be false now.
            return future.result()

    def hold(self, now: float, show: Callable[[], None]) -> None:
        """Execute pending requests, and let a tick last as long as it should.

        Args:
            now: Simulated time of the tick, s.
            show: Function called after each request, and once if the tick is paused.

        Raises:
            ReturnRequest: The run is asked to return to an earlier time.
        """
        self.now, is_shown = now, False
        # The sum of periods that is a tick's time may differ in its last digits.
        if now >= self._goal - 1e-9:
            self._goal = math.nan
            self.pause()
        while True:
            self.between()
            if self._answer():
                show()
            if (time := self.take_return()) is not None:
                raise ReturnRequest(time)
            with self._changed:
                if self._asked or not math.isnan(self._return):
                    continue
                if self.is_returning:
                    return
                pause = self._pause_at(now)
                if pause <= 0:
                    return
                must_show = self._paused and not is_shown
                if not must_show:
                    self._changed.wait(pause)
            # Without the lock, so that requests of pages do not wait for the frame.
            if must_show:
                is_shown = True
                show()

    def _answer(self) -> bool:
        """Execute pending requests, and return whether there were any."""
        with self._changed:
            asked, self._asked = self._asked, []
        for do, future in asked:
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(do())
                except Exception as error:
                    future.set_exception(error)
        return bool(asked)

    def _pause_at(self, now: float) -> float:
        """Return the remaining waiting time of the tick of a simulated time, s."""
        if self._paused:
            if self._steps > 0:
                self._steps -= 1
                return 0.0
            self._origin = None
            return 1.0
        # The tick of simulated time t is due at origin + t / speed. At infinite speed, each tick is
        # due immediately.
        clock = self._clock()
        ahead = now / self._speed
        if self._origin is None or clock - self._origin - ahead > _LATE:
            self._origin = clock - ahead
        return self._origin + ahead - clock

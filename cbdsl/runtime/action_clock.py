"""Clock of a program's run: the time of its action, without activity, and in total."""

from __future__ import annotations

from cbdsl.program.checked import CheckedProgram


class ActionClock:
    """Counter of control ticks, compared with the limits of a program.

    Args:
        program: Program with limits of time.
        period: Control period, s.

    Attributes:
        ticks: Number of ticks of the present action.
    """

    def __init__(self, program: CheckedProgram, period: float) -> None:
        self._program, self._period = program, period
        self.restart()

    def restart(self) -> None:
        """Begin an episode."""
        self._all = 0
        self.begin_action()

    def succeed(self, before: ActionClock) -> None:
        """Go on with the time of a clock of before."""
        self._all = before._all

    def begin_action(self) -> None:
        """Begin an action."""
        self.ticks = self._idle = 0

    def advance(self) -> None:
        """Count a tick of the present action."""
        self.ticks += 1
        self._all += 1

    def advance_search(self) -> None:
        """Count a tick before the first action."""
        self._all += 1

    @property
    def seconds(self) -> float:
        """Time of the present action, s."""
        return self.ticks * self._period

    @property
    def is_over(self) -> bool:
        """True if the present action has used up its time."""
        return self.seconds > self._program.transition_time

    @property
    def is_episode_over(self) -> bool:
        """True if the program has used up its time."""
        limit = self._program.episode_time
        return limit is not None and self._all * self._period >= limit

    def is_idle(self, *, strives: bool) -> bool:
        """Return whether the action has been without activity for too long.

        Args:
            strives: True if a controller of the action is active in this tick.
        """
        if self._program.idle_time is None:
            return False
        self._idle = 0 if strives else self._idle + 1
        return self._idle * self._period > self._program.idle_time

"""Watchdog: repeats references to a controller without a time-out, holds, and stops.

A forward controller keeps its last reference forever, and its robot continues to it even if the
program has failed. A watchdog is a separate process between the two:

    repeats   forwards each reference within all limits, and repeats the newest one
    waits     after a program that said that it rests, and whose references stand
    holds     after the deadline without a new one: brakes, and keeps the reference where it stands
    stops     after a while of holding: sends nothing more; a person starts it again

Silence alone never lets it wait, because a program that is hung or killed is silent, too.

Beside another commander of the controller it brakes and stops, because two would pull the robot.
"""

from __future__ import annotations

from enum import Enum

import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl_drive.limiter import COMPUTING, STANDING, JointLimits, Limiter

# Time for which references are repeated after a hold, s.
_HOLDING = 1.0
# Distance of a reference that is reached, rad or m.
_REACHED = 1e-6


class WatchdogPhase(Enum):
    """Phase of a watchdog."""

    WAITING = "waits for the first reference"
    REPEATING = "repeats"
    HOLDING = "holds"
    STOPPED = "has stopped"


class Watchdog:
    """Guard of one controller, for any transport.

    Args:
        limits: Limits of the joints.
        period: Time between two ticks, s.
        deadline: Longest time without a reference from the program while references move, s.
        start: Largest distance of the first reference from the measured positions, rad or m.

    Attributes:
        phase: Phase.
        cause: Reason of the hold, as a sentence without a full stop; empty before.
    """

    def __init__(self, limits: JointLimits, period: float, deadline: float, start: float) -> None:
        self._limiter, self._deadline, self._start = Limiter(limits, period), deadline, start
        self._period, self._is_resting = period, False
        self._limiter.reset(np.full(len(limits.lower), np.nan))
        # Requested references; empty while the watchdog waits, so that a hold then sends nothing.
        self._requested: Floats = np.zeros(0)
        self._heard = self._until = 0.0
        # Longest time without a reference now, and the time of the newest tick, s.
        self._patience, self._ticked = deadline, np.inf
        self._measured: Floats | None = None
        self.phase, self.cause = WatchdogPhase.WAITING, ""

    def note_positions(self, positions: Floats) -> None:
        """Take in measured positions, rad or m, shape (n,), unless one is not finite."""
        if np.isfinite(positions).all():
            self._measured = positions

    def request(self, references: Floats, now: float) -> None:
        """Take in references of the program.

        Args:
            references: Positions, rad or m, shape (n,).
            now: Time by a monotonic clock, s.
        """
        # A program that returns after a hold does not know where the robot is now.
        if self.phase in (WatchdogPhase.HOLDING, WatchdogPhase.STOPPED):
            return
        self._is_resting = False
        if not np.isfinite(references).all():
            self._hold("a reference is not finite", now)
            return
        if self.phase is WatchdogPhase.WAITING:
            # Without a measured position, the distance of the first reference is unknown.
            if self._measured is None:
                return
            if np.abs(references - self._measured).max() > self._start:
                self._hold(f"the first reference is over {self._start:g} from the robot", now)
                return
            # The controller keeps the last references, unless the robot was moved meanwhile.
            if not np.abs(self._limiter.positions - self._measured).max() <= self._start:
                self._limiter.reset(self._measured)
            self.phase, self._requested = WatchdogPhase.REPEATING, self._limiter.positions
        # A program whose references stand may compute for longer, as in a supervisor.
        moved = float(np.abs(references - self._requested).max(initial=0.0))
        stands = moved < STANDING * self._period
        self._patience = max(self._deadline, COMPUTING) if stands else self._deadline
        self._requested, self._heard = references, now

    def rest(self) -> None:
        """Take in that the program sends nothing more until it begins anew.

        The watchdog then waits as soon as references stand, and holds if they do not within the
        deadline.
        """
        self._is_resting, self._patience = True, self._deadline

    def yield_to(self, rival: str, now: float) -> None:
        """Hold because of another commander, unless it holds already.

        Args:
            rival: Cause as a sentence without a full stop.
            now: Time by a monotonic clock, s.
        """
        if self.phase in (WatchdogPhase.WAITING, WatchdogPhase.REPEATING):
            self._hold(rival, now)
            self._until = now

    def tick(self, now: float) -> Floats | None:
        """Return the references to send; ``None`` for none.

        Args:
            now: Time by a monotonic clock, s.
        """
        late, self._ticked = now - self._ticked, now
        if self.phase is WatchdogPhase.REPEATING:
            silent = now - self._heard
            # References that queued meanwhile arrive from now on, but their program may have ended.
            if late > self._period + self._deadline:
                # The controller has come to rest at the newest reference.
                self._limiter.reset(self._limiter.positions)
                self._hold(f"the watchdog was suspended for {1e3 * late:.0f} ms", now)
            elif self._is_resting and self._has_arrived:
                self.phase, self._requested = WatchdogPhase.WAITING, np.zeros(0)
            elif silent <= self._patience:
                return self._limiter.approach(self._requested)
            else:
                self._hold(f"no reference for {1e3 * silent:.0f} ms", now)
        if self.phase is WatchdogPhase.HOLDING:
            if now > self._until and self._limiter.stands:
                self.phase = WatchdogPhase.STOPPED
                return None
            return self._limiter.brake() if self._requested.size else None
        return None

    @property
    def _has_arrived(self) -> bool:
        """True if references stand where the program requested them."""
        here = self._limiter.positions
        return self._limiter.stands and bool(np.allclose(here, self._requested, atol=_REACHED))

    def _hold(self, cause: str, now: float) -> None:
        self.phase, self.cause, self._until = WatchdogPhase.HOLDING, cause, now + _HOLDING

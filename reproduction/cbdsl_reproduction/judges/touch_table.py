"""Whether ``touch_table`` presses fingertips on the table at its reward.

Fingertips on a table press in turn, so contact in at least half of the ticks of the last 0.1 s
counts.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

from cbdsl_reproduction.judges.judge import NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult

# Control ticks of 1/60 s in the last 0.1 s.
_LAST = 6


class _Presses(Watch):
    """Fingertips of the hand on the table in the last ticks."""

    def begin(self) -> None:
        """Forget all contacts."""
        self._last: deque[int] = deque(maxlen=_LAST)

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        hand = self.condition.values["hand"]
        self._last.append(sum(owner == hand for owner, _ in self.fingertips("table")))

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the reward agrees with the contacts."""
        is_pressing = 2 * sum(map(bool, self._last)) >= len(self._last)
        outcomes = {
            "rewarded": result.rewarded,
            "rewarded without contact": result.rewarded and not is_pressing,
        }
        measures = {"fingertips": float(max(self._last, default=0))}
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, result.ending, measures)


JUDGE = Judge(
    "touch_table",
    "fingertips of either hand pressed on the table",
    tuple(
        JudgedCondition(
            side,
            "touch_table",
            {"rewarded": Aim(0.95), "rewarded without contact": NONE},
            "bare_table",
            values={"arm": f"{side}_arm", "hand": f"{side}_hand"},
        )
        for side in ("right", "left")
    ),
    watched(_Presses),
    episodes=60,
)

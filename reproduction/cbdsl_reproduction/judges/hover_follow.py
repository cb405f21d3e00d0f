"""Whether ``hover_follow`` keeps the palm above a rolling ball.

The desired place of the palm is 17 cm above the top of the ball. An episode counts 30 s from 6 s
after its start; it succeeds if the palm is within 3 cm for 95 % of that time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult

_CLEARANCE, _WITHIN, _SHARE = 0.17, 0.03, 0.95
# Time that counts, s, and period of a control tick, s.
_FIRST, _LAST, _PERIOD = 6.0, 36.0, 1 / 60


class _Above(Watch):
    """Distances of the palm from its desired place."""

    def begin(self) -> None:
        """Forget all distances."""
        self._errors: list[float] = []
        tip = self.request.robot.effectors["right_arm"].tip
        assert tip is not None
        self._link, self._offset = tip.link, np.array(tip.offset)

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        if not _FIRST <= tick.observation.time <= _LAST:
            return
        (ball,) = self.shown
        above = np.array([0, 0, self.truth.half_extents(ball)[2] + _CLEARANCE])
        offset = self.truth.link_rotation(self._link) @ self._offset
        palm = self.truth.link_position(self._link) + offset
        self._errors.append(float(np.linalg.norm(palm - self.truth.position(ball) - above)))

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the palm followed; ticks after the end of an episode count as missed."""
        near = sum(error <= _WITHIN for error in self._errors)
        share = min(1.0, near * _PERIOD / (_LAST - _FIRST))
        measures = {"share_percent": 100 * share}
        if self._errors:
            measures["median_error_mm"] = 1e3 * float(np.median(self._errors))
        outcomes = {"followed": share >= _SHARE}
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, result.ending, measures)


JUDGE = Judge(
    "hover_follow",
    "a hand kept above a rolling ball",
    (JudgedCondition("rolling ball", "hover_follow", {"followed": Aim(0.95)}, "rolling_by"),),
    watched(_Above),
)

"""Whether ``ensure_stacked`` leaves a standing pair alone, and stacks the objects otherwise.

At the end the lower object alone bears the upper one, which is at rest and in no hand. If it stood
there at the first tick, the robot has touched no object.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from cbdsl_reproduction.judges.claim_judges import ClaimWatch, left_alone_or_stacked
from cbdsl_reproduction.judges.judge import (
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult


class _Pair(Watch):
    """Truth about both objects."""

    def begin(self) -> None:
        """Forget the previous episode."""
        self._claim = ClaimWatch(self.truth, ("lower", "upper"))

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        self._claim.note(tick)

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the pair stands, untouched if it stood before."""
        fault = left_alone_or_stacked(self._claim)
        is_claimed = result.outcome == "success"
        outcomes = {
            "stands": is_claimed and not fault,
            "false success": is_claimed and bool(fault),
        }
        ending = fault if is_claimed and fault else result.ending
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, ending)


def _condition(name: str, context: str) -> JudgedCondition:
    aims = {"stands": Aim(0.9), "false success": NONE}
    return JudgedCondition(name, "ensure_stacked", aims, context=context)


JUDGE = Judge(
    "ensure_stacked",
    "a pair of boxes that is recognised and left alone, or stacked",
    (
        _condition("boxes that stand already", "stacked"),
        _condition("boxes beside each other", "beside"),
        _condition("upper box on another one", "on_another"),
    ),
    watched(_Pair),
    BodyChoice("mujoco", "ideal"),
)

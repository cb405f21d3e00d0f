"""Whether ``find_the_other`` touches one of two red balls, and then the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from cbdsl_reproduction.judges.judge import NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult

_BALLS = ("one", "other")
_FINGERS = 3


class _Turns(Watch):
    """Order in which three fingertips were on the balls."""

    def begin(self) -> None:
        """Forget all contacts."""
        self._held: list[str] = []

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        for name in _BALLS:
            if name not in self._held and len(self.fingertips(name)) >= _FINGERS:
                self._held.append(name)

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the reward agrees with the contacts."""
        at_end = [len(self.fingertips(name)) for name in self._held]
        in_turn = len(at_end) == len(_BALLS) and at_end[0] == 0 and at_end[1] >= _FINGERS
        outcomes = {
            "rewarded": result.rewarded,
            "rewarded without contacts": result.rewarded and not in_turn,
        }
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, result.ending)


JUDGE = Judge(
    "find_the_other",
    "touch one of two red balls, then the other",
    (
        JudgedCondition(
            "two red balls",
            "find_the_other",
            {"rewarded": Aim(0.95), "rewarded without contacts": NONE},
            "two_red_balls",
        ),
    ),
    watched(_Turns),
)

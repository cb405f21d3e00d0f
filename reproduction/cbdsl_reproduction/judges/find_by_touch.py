"""Whether ``find_by_touch`` touches an object in the dark when it reports one."""

from __future__ import annotations

from typing import TYPE_CHECKING

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


class _Found(Watch):
    """Contact of the robot with an object at the end."""

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the report agrees with the contact."""
        things = set(self.truth.objects).intersection(self.request.stage.things)
        is_touched = any(map(self.truth.is_touched, things))
        is_reported = result.outcome == "success"
        # An attempt without success has two transitions: its begin and its end.
        states = result.predicates[1:]
        return EpisodeVerdict(
            result.seed,
            {
                "found": is_reported and is_touched,
                "reported without contact": is_reported and not is_touched,
            },
            result.sim_seconds,
            result.ending,
            {"attempts": float(states.count("0") or len(states))},
        )


JUDGE = Judge(
    "find_by_touch",
    "objects found in the dark",
    (
        JudgedCondition(
            "dark",
            "find_by_touch",
            {"found": Aim(0.9), "reported without contact": NONE},
            context="dark",
        ),
    ),
    watched(_Found),
    BodyChoice("mujoco", None),
)

"""How often shipped programs are rewarded, and whether fingertips touch the object then."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl_reproduction.judges.judge import ANY, NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cbdsl import EpisodeResult

_LEFT = {"arm": "left_arm", "hand": "left_hand"}
_FINGERS = 3


class _Contacts(Watch):
    """Contacts of fingertips with the object at the end."""

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the program is rewarded, and by how many fingertips."""
        touching = len(self.fingertips(*self.shown))
        outcomes = {
            "rewarded": result.rewarded,
            "rewarded without three contacts": result.rewarded and touching < _FINGERS,
            "fallen": self._has_fallen(),
        }
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, result.ending)

    def _has_fallen(self) -> bool:
        """Return whether an object is below the centres of all fixtures."""
        height = {name: float(self.truth.position(name)[2]) for name in self.truth.objects}
        # The centre of a table lies below its top, so that an object on the table counts as not
        # fallen.
        fixtures = [height[name] for name in self.request.stage.fixtures if name in height]
        return bool(fixtures) and any(height[name] < min(fixtures) for name in self.shown)


def _condition(
    name: str,
    stage: str,
    aim: Aim,
    program: str = "reachtouch",
    values: Mapping[str, str] | None = None,
) -> JudgedCondition:
    aims = {"rewarded": aim, "rewarded without three contacts": ANY, "fallen": ANY}
    return JudgedCondition(name, program, aims, stage, values=values or {})


JUDGE = Judge(
    "success_rates",
    "rewards of shipped programs, with the contacts of fingertips",
    (
        _condition("right", "table_right", Aim(0.97)),
        _condition("left", "table_left", Aim(0.97), values=_LEFT),
        _condition("right arm on left half", "table_left", Aim(0.9)),
        _condition("left arm on right half", "table_right", Aim(0.9), values=_LEFT),
        _condition("moving at 5 cm/s", "moving_right", Aim(0.9)),
        _condition("noisy and miscalibrated", "noisy_right", Aim(0.9)),
        _condition("out of reach", "out_of_reach", NONE),
        _condition("absent", "absent", NONE),
        _condition("thrown away", "thrown", NONE),
        _condition("tactileprobe", "held_right", ANY, "tactileprobe"),
        _condition("visualinspect", "spotted_right", ANY, "visualinspect"),
        _condition("bimanualtouch", "table_right", ANY, "bimanualtouch"),
    ),
    watched(_Contacts),
    episodes=100,
)

"""Whether ``deliver`` places everyday objects, or refuses them before an arm moves.

The stage ``other_objects`` has objects of sizes for which no bound was chosen, except for the
chisel. Which objects count as placed and which as refused was set after runs on development seeds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.claim_judges import ClaimWatch, delivered
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cbdsl import EpisodeResult

# Largest turn of an arm's joint without motion, rad.
_STILL = 0.05
#: Objects that are placed, and objects that are refused, by stage.
_PLACED = {
    "everyday_objects": (
        "block", "matchbox", "carton", "soup_can", "tuna_can", "bottle", "jar", "mug",
        "tennis_ball", "softball", "screwdriver",
    ),
    "other_objects": ("tin", "cube", "soap", "shampoo", "handball", "candle", "chisel"),
}  # fmt: skip
_REFUSED = {
    "everyday_objects": (
        "die", "cereal_box", "parcel", "book", "paperback", "paint_can", "canister", "bowl",
        "tray", "golf_ball", "medicine_ball", "play_ball", "hammer",
    ),
    "other_objects": ("marble", "plate", "crate", "detergent", "rod"),
}  # fmt: skip


class _Delivery(Watch):
    """Truth about the object, and the largest turn of the arms' joints."""

    def begin(self) -> None:
        """Forget the previous episode."""
        self._first: NDArray[np.float64] | None = None
        self._turn = 0.0
        self._claim = ClaimWatch(self.truth, [self.condition.context or ""])

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        self._claim.note(tick)
        joints = tick.signals.joints
        arms = [k for arm in ("left_arm", "right_arm") for k in joints.of(arm)]
        now = tick.observation.positions[arms]
        if self._first is None:
            self._first = now.copy()
        self._turn = max(self._turn, float(np.abs(now - self._first).max()))

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object was placed, or refused before motion."""
        is_success = result.outcome == "success"
        fault = delivered(self._claim) if is_success else ""
        outcomes = {
            "placed": is_success and not fault,
            "refused before motion": result.outcome == "failure" and self._turn < _STILL,
            "false success": bool(fault),
        }
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, fault or result.ending)


def _conditions() -> tuple[JudgedCondition, ...]:
    """Return each object of both stages."""
    most, conditions = Aim(0.9), []
    for objects, aims in (
        (_PLACED, {"placed": most, "refused before motion": ANY, "false success": NONE}),
        (_REFUSED, {"placed": ANY, "refused before motion": most, "false success": NONE}),
    ):
        conditions += [
            JudgedCondition(name, "deliver", aims, stage, name)
            for stage, names in objects.items()
            for name in names
        ]
    return tuple(conditions)


JUDGE = Judge(
    "everyday",
    "everyday objects placed on a pad, or refused before motion",
    _conditions(),
    watched(_Delivery),
    BodyChoice("mujoco", "ideal"),
)

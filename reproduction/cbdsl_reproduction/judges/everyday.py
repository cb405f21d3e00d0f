"""Whether ``deliver`` places everyday objects, or refuses them before an arm moves.

The stage ``other_objects`` has objects of sizes for which no bound was chosen, except for the
chisel. ``tall_objects`` has objects that are taken from the side, chosen with that grasp. Which
objects are to be placed and which refused was set after runs on development seeds.
Outcomes are counted apart: a refusal is no placement, and an object that is put back is neither.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.claim_judges import CLAIM_OF, STILL, ClaimWatch
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
# Largest distance of an object that is put back from its first place, m, and least cosine of the
# angle between the vertical axes in its frame, at the first tick and at the end: 8 degrees.
_NEAR, _UPRIGHT = 0.1, 0.99
#: Objects that are to be placed, to be refused, and whose weight a first lift shows, by stage.
_PLACED = {
    "everyday_objects": (
        "die", "golf_ball", "block", "matchbox", "carton", "soup_can", "tuna_can", "bottle",
        "jar", "mug", "tennis_ball", "softball", "screwdriver", "parcel",
    ),
    "other_objects": (
        "tin", "cube", "soap", "shampoo", "handball", "candle", "chisel", "marble", "hatbox",
        "chest", "drum",
    ),
    "tall_objects": ("wine_bottle", "spray_can", "vase", "milk", "pasta", "tube"),
}  # fmt: skip
_REFUSED = {
    "everyday_objects": (
        "cereal_box", "book", "paperback", "bowl", "tray", "medicine_ball", "play_ball",
        "hammer",
    ),
    "other_objects": ("plate", "crate", "detergent", "rod"),
}  # fmt: skip
_WEIGHED = {"everyday_objects": ("paint_can", "canister")}


class _Delivery(Watch):
    """Truth about the object, and the largest turn of the arms' joints."""

    def begin(self) -> None:
        """Forget the previous episode."""
        self._first: NDArray[np.float64] | None = None
        self._vertical: NDArray[np.float64] = np.zeros(3)
        self._turn = 0.0
        self._claim = ClaimWatch(self.truth, [self.condition.context or ""])

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        self._claim.note(tick)
        # The head moves while it looks, so that a refusal is judged by the arms alone.
        joints = tick.signals.joints
        arms = [k for arm in ("left_arm", "right_arm") for k in joints.of(arm)]
        now = tick.observation.positions[arms]
        if self._first is None:
            self._first, self._vertical = now.copy(), self._vertical_axis()
        self._turn = max(self._turn, float(np.abs(now - self._first).max()))

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object was placed, or refused before motion."""
        is_success, is_failure = (result.outcome == name for name in ("success", "failure"))
        fault = CLAIM_OF["deliver"].judge(self._claim) if is_success else ""
        outcomes = {
            "placed": is_success and not fault,
            "refused before motion": is_failure and self._turn < _STILL,
            "put back": is_failure and self._turn >= _STILL and self._is_back(),
            "false success": bool(fault),
        }
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, fault or result.ending)

    def _is_back(self) -> bool:
        """Return whether the object stands at rest near its first place, and nothing holds it."""
        (name,) = self._claim.things
        is_upright = float(self._vertical @ self._vertical_axis()) > _UPRIGHT
        is_at_rest = not self._claim.is_held(name) and self._claim.speed(name) < STILL
        return bool(is_upright and is_at_rest and self._claim.shift(name) < _NEAR)

    def _vertical_axis(self) -> NDArray[np.float64]:
        """Return the world's vertical axis in the object's frame, shape (3,)."""
        (name,) = self._claim.things
        axis: NDArray[np.float64] = self.truth.rotation(name)[2]
        return axis


def _conditions() -> tuple[JudgedCondition, ...]:
    """Return each object of the stages."""
    placed = {"placed": Aim(0.9), "refused before motion": ANY, "false success": NONE}
    refused = {"placed": ANY, "refused before motion": Aim(0.9), "false success": NONE}
    weighed = {"put back": ANY, **placed}
    groups = ((_PLACED, placed), (_REFUSED, refused), (_WEIGHED, weighed))
    return tuple(
        JudgedCondition(name, "deliver", aims, stage, name)
        for objects, aims in groups
        for stage, names in objects.items()
        for name in names
    )


JUDGE = Judge(
    "everyday",
    "everyday objects placed on a pad, or refused before motion",
    _conditions(),
    watched(_Delivery),
    BodyChoice("mujoco", "ideal"),
)

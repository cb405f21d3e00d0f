"""Whether ``pick_and_lift`` keeps objects in the hand, and how far they move in it.

An object is kept if the program succeeds with it within 6 cm of its place in the hand at the grasp.
It is steady if it drifts and tilts little in the hand's frame.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cbdsl import EpisodeResult, Transition

    Floats = NDArray[np.float64]

# Largest distance of a kept object from its place in the hand, m.
_LOST = 0.06
# Largest drift of a steady object by engine, m.
_DRIFT = {"bullet": 0.008, "mujoco": 0.004}
_TILT, _FORCE = math.radians(5.0), 15.0  # rad, N


class _Hold(Watch):
    """Place of the object in the hand, and forces on its fingertips."""

    def begin(self) -> None:
        """Forget the grasp."""
        self._grasp: tuple[Floats, Floats] | None = None
        self._force = 0.0
        self._values = self.condition.values
        tip = self.request.robot.effectors[self._values["arm"]].tip
        assert tip is not None
        self._palm = tip.link

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        for (hand, _), force in self.truth.fingertip_forces().items():
            if hand == self._values["hand"]:
                self._force = max(self._force, float(np.linalg.norm(force)))

    def hear(self, transition: Transition) -> None:
        """Take in a change of state."""
        if transition.action == "grip" and transition.reward:
            self._grasp = self._in_hand()

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object is still in the hand."""
        measures, drift, tilt = {"force_N": self._force}, math.inf, math.inf
        if self._grasp is not None:
            (start, up), (position, upright) = self._grasp, self._in_hand()
            drift = float(np.linalg.norm(position - start))
            tilt = math.acos(min(1.0, float(up @ upright)))
            measures |= {"drift_mm": 1e3 * drift, "tilt_deg": math.degrees(tilt)}
        most = _DRIFT.get(self.body.backend, _DRIFT["bullet"])
        is_kept = result.outcome == "success" and drift < _LOST
        return EpisodeVerdict(
            result.seed,
            {
                "kept": is_kept,
                "steady": is_kept and drift <= most and tilt <= _TILT,
                "force above 15 N": self._force > _FORCE,
            },
            result.sim_seconds,
            result.ending,
            measures,
        )

    def _in_hand(self) -> tuple[Floats, Floats]:
        """Return the object's position, m, and upright axis in the hand's frame, each (3,)."""
        thing = self.condition.context
        assert thing is not None
        axes = self.truth.link_rotation(self._palm).T
        offset = self.truth.position(thing) - self.truth.link_position(self._palm)
        return axes @ offset, axes @ self.truth.rotation(thing)[:, 2]


def _conditions() -> tuple[JudgedCondition, ...]:
    """Return each object in the right hand, then in the left."""
    aims = {"kept": Aim(0.97), "steady": Aim(0.9), "force above 15 N": NONE}
    return tuple(
        JudgedCondition(
            thing if side == "right" else f"{thing}, left hand",
            "pick_and_lift",
            aims,
            context=thing,
            values={"arm": f"{side}_arm", "hand": f"{side}_hand"},
        )
        for side in ("right", "left")
        for thing in ("ball", "cube", "cylinder", "light_box")
    )


JUDGE = Judge(
    "holding",
    "objects kept in the hand while they are lifted and carried",
    _conditions(),
    watched(_Hold),
    episodes=40,
)

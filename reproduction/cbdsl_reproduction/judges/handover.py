"""Whether ``handover`` passes balls, cubes and cylinders from hand to hand, in both directions.

The giving hand carried the object alone, and no other object bore it since then. At the end only
the receiving hand touches the object. The object kept its place in that hand since the other hand
released it, and is above the table and away from the other hand.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import ANY, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cbdsl import EpisodeResult

    Floats = NDArray[np.float64]

_OTHER = {"right": "left", "left": "right"}
# Largest slip in the receiving hand, least height above the table's top, and least distance from
# the giving hand's palm, m.
_DRIFT, _HEIGHT, _APART = 0.03, 0.15, 0.20
_TABLE_TOP = -0.42  # m
# Control ticks of 1/60 s for which the giving hand has to carry the object.
_CARRIED = 6


class _Passed(Watch):
    """Places of the object in the receiving hand since it holds the object alone."""

    def begin(self) -> None:
        """Forget the previous episode."""
        assert self.condition.context is not None
        self._thing, _, self._giver = self.condition.context.rpartition("_")
        self._taker = _OTHER[self._giver]
        self._alone: list[Floats] = []
        self._force, self._carried = 0.0, 0

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        forces = self.truth.fingertip_forces().values()
        self._force = max(self._force, *(float(np.linalg.norm(force)) for force in forces))
        hands = {hand for hand, _ in self.truth.touching(self._thing)}
        if self.truth.pressing(self._thing):
            self._carried = 0
        elif hands == {f"{self._giver}_hand"}:
            self._carried += 1
        if hands == {f"{self._taker}_hand"}:
            self._alone.append(self._in_hand())
        else:
            self._alone.clear()

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the receiving hand alone holds the object that the other one carried."""
        place = self.truth.position(self._thing)
        apart = float(np.linalg.norm(place - self.truth.link_position(f"{self._giver}_palm")))
        drift = float(np.linalg.norm(self._alone[-1] - self._alone[0])) if self._alone else np.inf
        is_aloft = float(place[2]) >= _TABLE_TOP + _HEIGHT and apart >= _APART
        is_passed = self._carried >= _CARRIED and drift <= _DRIFT and is_aloft
        is_reported = result.outcome == "success"
        measures = {"force_N": self._force} | ({"drift_mm": 1e3 * drift} if self._alone else {})
        return EpisodeVerdict(
            result.seed,
            {
                "handed over": is_reported and is_passed,
                "reported wrongly": is_reported and not is_passed,
            },
            result.sim_seconds,
            result.ending,
            measures,
        )

    def _in_hand(self) -> Floats:
        """Return the object's place in the receiving hand's frame, m, shape (3,)."""
        palm = f"{self._taker}_palm"
        offset = self.truth.position(self._thing) - self.truth.link_position(palm)
        place: Floats = self.truth.link_rotation(palm).T @ offset
        return place


JUDGE = Judge(
    "handover",
    "objects passed from hand to hand",
    tuple(
        JudgedCondition(
            f"{thing} from the {giver}",
            "handover",
            {"handed over": Aim(least), "reported wrongly": ANY},
            context=f"{thing}_{giver}",
            values={"arm": f"{_OTHER[giver]}_arm"},
        )
        for thing, least in (("ball", 0.95), ("cube", 0.9), ("cylinder", 0.9))
        for giver in ("right", "left")
    ),
    watched(_Passed),
)

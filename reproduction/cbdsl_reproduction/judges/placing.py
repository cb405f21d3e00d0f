"""Whether ``take_and_put_down`` puts objects down, and whether reported contacts are true.

Episodes count if the object was in the hand, off the table, before it was put down. It is placed if
it ends within 2 cm of the point below, released, borne, at rest, and tilted by less than 10
degrees. A report of contact is false if the object touched nothing within 0.1 s before. A contact
is missed if it lasted for 1 s without a report.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from cbdsl import EpisodeResult

    Floats = NDArray[np.float64]

_CLOSE, _FLAT, _STILL = 0.02, math.radians(10.0), 0.01  # m, rad, m/s
# Control ticks of 1/60 s for which a contact counts as reported, and after which it is missed.
_BEFORE, _LONG = 6, 60


class _PutDown(Watch):
    """Contacts of the object while it is put down."""

    def begin(self) -> None:
        """Forget all contacts."""
        self._thing = ""
        self._held: Floats | None = None
        self._has_begun = self._is_reported = self._is_false = self._is_missed = False
        self._tick = self._touched = 0
        self._last_touch = -_BEFORE - 1

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        self._tick += 1
        if not self._thing:
            (self._thing,) = (name for name in self.truth.objects if name != "table")
            self._upright = self.truth.rotation(self._thing)[:, 2]
        run = tick.run.children["put_down"]
        if run.predicate == "X":
            return
        is_borne = bool(self.truth.pressing(self._thing))
        if not self._has_begun:
            self._has_begun = True
            if not is_borne and self.truth.is_touched(self._thing):
                self._held = self.truth.position(self._thing)
        if is_borne:
            self._last_touch = self._tick
        self._judge_report(run, is_borne)

    def _judge_report(self, run: Any, is_borne: bool) -> None:
        """Compare a report of contact, or the lack of one, with the contact."""
        if run.state[run.program.members.index("place")] in "01":
            if not self._is_reported:
                self._is_false = self._tick - self._last_touch > _BEFORE
            self._is_reported = True
        elif run.action is not None and run.action.name.startswith("lower"):
            self._touched += is_borne and not self._is_reported
            self._is_missed |= self._touched >= _LONG

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object is below the point where it was held."""
        held = self._held
        if held is None:
            outcomes = dict.fromkeys(("placed", "false report", "missed contact"))
            return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, result.ending)
        error = math.dist(self.truth.position(self._thing)[:2], held[:2])
        cosine = min(1.0, float(self.truth.rotation(self._thing)[:, 2] @ self._upright))
        # A ball may roll on its way, so that its axes do not matter.
        tilt = 0.0 if self._thing == "ball" else math.acos(cosine)
        is_resting = float(np.linalg.norm(self.truth.velocity(self._thing))) < _STILL
        is_borne = bool(self.truth.pressing(self._thing))
        is_alone = is_borne and not self.truth.is_touched(self._thing)
        is_placed = is_resting and is_alone and error < _CLOSE and tilt < _FLAT
        return EpisodeVerdict(
            result.seed,
            {
                "placed": is_placed and result.outcome == "success",
                "false report": self._is_false,
                "missed contact": self._is_missed and not self._is_reported,
            },
            result.sim_seconds,
            result.ending,
            {"error_mm": 1e3 * error, "tilt_deg": math.degrees(tilt)},
        )


JUDGE = Judge(
    "placing",
    "objects that are taken, lifted and put down",
    tuple(
        JudgedCondition(
            f"{side} hand",
            "take_and_put_down",
            {"placed": Aim(0.95), "false report": NONE, "missed contact": Aim(most=0.02)},
            stage,
            values={"arm": f"{side}_arm", "hand": f"{side}_hand"},
        )
        for side, stage in (("right", None), ("left", "table_left"))
    ),
    watched(_PutDown),
    episodes=200,
)

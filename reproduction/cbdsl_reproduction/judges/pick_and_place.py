"""Whether ``deliver`` places an object on a seen pad.

An object is placed if it ends within 2 cm of the pad's centre, released, borne, at rest, and tilted
by less than 10 degrees. A reward of ``pick_and_place`` is false if nothing but the hand touched the
object within 0.1 s before.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult, Transition

_CLOSE, _FLAT, _STILL = 0.02, math.radians(10.0), 0.01  # m, rad, m/s
# Control ticks of 1/60 s for which a contact counts as felt.
_BEFORE = 6


class _Pad(Watch):
    """Contacts, and the final pose, of the object of the context."""

    def begin(self) -> None:
        """Forget all contacts."""
        self._upright: Any = None
        self._tick, self._last_touch = 0, -_BEFORE - 1
        self._is_false = False

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        if self._upright is None:
            self._upright = self.truth.rotation(self._thing)[:, 2]
        self._tick += 1
        self._note_contact(self._tick)

    def hear(self, transition: Transition) -> None:
        """Take in a change of state, which comes before its tick."""
        if transition.program == "pick_and_place" and transition.reward:
            self._note_contact(self._tick + 1)
            self._is_false |= self._tick + 1 - self._last_touch > _BEFORE

    def _note_contact(self, tick: int) -> None:
        if self.truth.pressing(self._thing):
            self._last_touch = tick

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object is on the pad."""
        position, rotation = self.truth.position(self._thing), self.truth.rotation(self._thing)
        error = math.dist(position[:2], self.truth.position("pad")[:2])
        cosine = min(1.0, float(rotation[:, 2] @ self._upright))
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
                "rewarded without contact": self._is_false,
            },
            result.sim_seconds,
            result.ending,
            {"error_mm": 1e3 * error, "tilt_deg": math.degrees(tilt)},
        )

    @property
    def _thing(self) -> str:
        """Name of the object, which is the context's name."""
        assert self.condition.context is not None
        return self.condition.context


JUDGE = Judge(
    "pick_and_place",
    "objects placed on a seen pad",
    tuple(
        JudgedCondition(
            thing,
            "deliver",
            {"placed": Aim(least), "rewarded without contact": NONE},
            context=thing,
        )
        for thing, least in (("ball", 0.97), ("cube", 0.95), ("cylinder", 0.95), ("box", 0.95))
    ),
    watched(_Pad),
    episodes=100,
)

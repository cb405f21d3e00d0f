"""Whether ``take_with_both`` takes a large object between both hands, and lifts it.

A reward has contact if both hands touched the object within 0.1 s before. An object is lifted if
it ends 5 cm higher, in both hands, and nothing else presses on it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cbdsl_reproduction.judges.judge import ANY, NONE, Aim, EpisodeVerdict, Judge, JudgedCondition
from cbdsl_reproduction.judges.watch import Watch, watched

if TYPE_CHECKING:
    from cbdsl import EpisodeResult, Transition

_HANDS = ("right_hand", "left_hand")
_LIFTED = 0.05  # m
# Control ticks of 1/60 s for which a contact counts as felt.
_BEFORE = 6


class _Hands(Watch):
    """Contacts of both hands with the object of the context."""

    def begin(self) -> None:
        """Forget all contacts."""
        self._last_touch = dict.fromkeys(_HANDS, -_BEFORE - 1)
        self._tick = 0
        self._start: float | None = None
        self._is_false = False
        self._force = 0.0

    def note(self, tick: Any) -> None:
        """Take in a control tick."""
        self._tick += 1
        if self._start is None:
            self._start = self._height()
        self._note_contact(self._tick)
        forces = self.truth.fingertip_forces().values()
        self._force = max(self._force, *(float(np.linalg.norm(force)) for force in forces))

    def hear(self, transition: Transition) -> None:
        """Take in a change of state, which comes before its tick.

        Rewards of programs that it uses are not for the hands.
        """
        if transition.depth == 0 and "squeeze" in transition.rewarding:
            self._note_contact(self._tick + 1)
            oldest = min(self._last_touch.values())
            self._is_false |= self._tick + 1 - oldest > _BEFORE

    def _note_contact(self, tick: int) -> None:
        for hand, _ in self.truth.touching(self._thing):
            self._last_touch[hand] = tick

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return whether the object is in both hands."""
        assert self._start is not None
        height = self._height() - self._start
        hands = {hand for hand, _ in self.truth.touching(self._thing)}
        # An object that leans on the table is not lifted, even if its centre is high enough.
        is_held = hands == set(_HANDS) and not self.truth.pressing(self._thing)
        return EpisodeVerdict(
            result.seed,
            {
                "rewarded": result.rewarded,
                "rewarded without contact": self._is_false,
                "lifted": height > _LIFTED and is_held,
            },
            result.sim_seconds,
            result.ending,
            {"height_mm": 1e3 * height, "force_N": self._force},
        )

    def _height(self) -> float:
        """Return the height of the object, m."""
        return float(self.truth.position(self._thing)[2])

    @property
    def _thing(self) -> str:
        """Name of the object, which is the context's name."""
        assert self.condition.context is not None
        return self.condition.context


JUDGE = Judge(
    "both_hands",
    "large objects taken with both hands",
    tuple(
        JudgedCondition(
            thing,
            "take_with_both",
            {"rewarded": Aim(0.9), "rewarded without contact": NONE, "lifted": ANY},
            "large_things",
            thing,
            {"feature": "red"},
        )
        for thing in ("ball", "box")
    ),
    watched(_Hands),
    episodes=40,
)

"""Pairs of objects whose impedance is measured: the source's six, and held-out ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

PLANE, CYLINDRICAL, PRISMATIC, SPHERICAL = RELATIONS = (
    "plane_on_plane",
    "cylindrical",
    "prismatic",
    "spherical",
)

# Distance by which an object is lowered from its approach height: on another object it comes to
# rest before that; into another one it goes 5 cm deep.
_ON, _INTO = {"depth": "14 cm"}, {"depth": "8 cm"}


class ThingPair(NamedTuple):
    """Object on another one, or in it.

    Attributes:
        stage: Stage with a context of the pair's name.
        relation: One of ``RELATIONS``; spherical if one of both is round at the contact.
        values: Values of the program's parameters.
        stiff, free: Directions that are tracked, and not tracked, in Figure 7.13. Directions
            that depend on friction are in neither.
    """

    stage: str
    relation: str
    values: Mapping[str, str]
    stiff: tuple[str, ...] = ()
    free: tuple[str, ...] = ()

    @property
    def judged(self) -> tuple[str, ...]:
        """Directions whose signs the source reports."""
        return self.stiff + self.free

    def right(self, tracked: Mapping[str, bool]) -> list[bool]:
        """Return for each judged direction whether it is tracked, or not, as in the source."""
        return [tracked[each] == (each in self.stiff) for each in self.judged]


_PLANE = (("dPz", "dRx", "dRy"), ("dPx", "dPy", "dRz"))
_ROLLING = (("dPz",), ("dPx", "dPy", "dRx", "dRy", "dRz"))
_CYLINDRICAL = (("dPx", "dPy", "dRx", "dRy"), ("dPz", "dRz"))
_PRISMATIC = (("dPx", "dPy", "dRx", "dRy", "dRz"), ("dPz",))
# Friction keeps a ball from sliding on a box in some directions and episodes, not in others.
_BALL = (("dPz",), ("dRz",))

#: Six pairs of Section 7.2.1, by their contexts of the stage.
PAIRS: Mapping[str, ThingPair] = {
    "box_on_box": ThingPair("pairs", PLANE, _ON, *_PLANE),
    "ball_on_box": ThingPair("pairs", SPHERICAL, _ON, *_BALL),
    "box_on_ball": ThingPair("pairs", SPHERICAL, _ON, *_ROLLING),
    "football_on_ball": ThingPair("pairs", SPHERICAL, _ON, *_ROLLING),
    "cylinder_in_cylinder": ThingPair("pairs", CYLINDRICAL, _INTO, *_CYLINDRICAL),
    "box_in_box": ThingPair("pairs", PRISMATIC, _INTO, *_PRISMATIC),
}

#: Pairs of other sizes and forms, whose relations are to be identified.
OTHER_PAIRS: Mapping[str, ThingPair] = {
    "can_on_slab": ThingPair("other_pairs", PLANE, _ON, *_PLANE),
    "box_on_drum": ThingPair("other_pairs", PLANE, _ON, *_PLANE),
    "ball_on_drum": ThingPair("other_pairs", SPHERICAL, _ON, *_BALL),
    "can_on_ball": ThingPair("other_pairs", SPHERICAL, _ON, *_ROLLING),
    "peg_in_tube": ThingPair("other_pairs", CYLINDRICAL, _INTO, *_CYLINDRICAL),
    "bar_in_tray": ThingPair("other_pairs", PRISMATIC, _INTO, *_PRISMATIC),
}

ALL_PAIRS: Mapping[str, ThingPair] = {**PAIRS, **OTHER_PAIRS}

"""Context letters: what is seen of a thing, as predicates of a state (Section 5.3.1.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping

#: How many letters a state has for the context.
LETTERS = 3

# What counts as large, m^3, is halfway in size between the largest small thing and the smallest
# large one of the stage; half of the speed of what moves counts as moving, m/s.
_LARGE, _MOVING = 0.012, 0.025
_UNKNOWN = "?"


def context_letters(features: Mapping[str, float]) -> str:
    """Where a thing goes, on which side it is and how large: ``l``, ``r``, ``s`` and ``L``.

    Args:
        features: ``place.y``, ``velocity.y`` and ``volume``, in SI; NaN or left out where they are
            undefined, of which the letter is a question mark.
    """
    speed, side, size = (
        features.get(name, math.nan) for name in ("velocity.y", "place.y", "volume")
    )
    motion = _UNKNOWN if math.isnan(speed) else "s" if abs(speed) < _MOVING else _side(speed)
    scale = _UNKNOWN if math.isnan(size) else "L" if size > _LARGE else "s"
    return motion + _side(side) + scale


def _side(y: float) -> str:
    return _UNKNOWN if math.isnan(y) else "l" if y > 0 else "r"

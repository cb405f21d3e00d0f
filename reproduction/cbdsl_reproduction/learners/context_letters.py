"""Context letters: perceived features of an object, as predicates of a state (Section 5.3.1.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping

#: Number of letters of the context in a state.
LETTERS = 3

# The volume that counts as large, m^3, is halfway between the largest small object and the smallest
# large object of the stage. The speed that counts as moving, m/s, is half of a moving object's.
_LARGE, _MOVING = 0.012, 0.025
_UNKNOWN = "?"


def context_letters(features: Mapping[str, float]) -> str:
    """Return letters for an object's motion, side and size: ``l``, ``r``, ``s`` and ``L``.

    Args:
        features: ``place.y``, ``velocity.y`` and ``volume``, in SI; a feature that is NaN or
            missing gives a question mark.
    """
    speed, side, size = (
        features.get(name, math.nan) for name in ("velocity.y", "place.y", "volume")
    )
    motion = _UNKNOWN if math.isnan(speed) else "s" if abs(speed) < _MOVING else _side(speed)
    scale = _UNKNOWN if math.isnan(size) else "L" if size > _LARGE else "s"
    return motion + _side(side) + scale


def _side(y: float) -> str:
    return _UNKNOWN if math.isnan(y) else "l" if y > 0 else "r"

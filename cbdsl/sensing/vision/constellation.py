"""Constellations: relative scale and orientation of two blobs (Section 7.3.1, Fig 7.15)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.blob import Blob


class Constellation(NamedTuple):
    """Relative scales of two blobs, and their relative orientation.

    Their relative position is not included, as in the dissertation.

    Attributes:
        longer: Ratio of du of the first blob to that of the second.
        shorter: Ratio of dv of the first blob to that of the second.
        turn: Angle psi of the first blob's longer axis from that of the second, rad, above -pi/2 up
            to pi/2; 0 if either blob is round and so has no longer axis.
    """

    longer: float
    shorter: float
    turn: float

    @property
    def value(self) -> Floats:
        """Longer and shorter ratio and turn, shape (3,)."""
        return np.array(self)


def constellation_of(first: Blob, second: Blob) -> Constellation:
    """Return the constellation of two blobs."""
    longer, shorter = (first.extent / second.extent).tolist()
    axes = first.orientation, second.orientation
    turn = 0.0 if axes[0] is None or axes[1] is None else half_turn(axes[0] - axes[1])
    return Constellation(longer, shorter, turn)


def half_turn(angle: float) -> float:
    """Return an angle modulo half a turn, rad, above -pi/2 up to pi/2."""
    return angle - math.pi * math.ceil(angle / math.pi - 0.5)

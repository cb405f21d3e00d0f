"""Constellations: how two blobs look beside each other (Section 7.3.1, Fig 7.15)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.blob import Blob

Floats = NDArray[np.float64]


class Constellation(NamedTuple):
    """Relative scales of two blobs, and their relative orientation.

    Where they are from each other is no part of it, as in the source.

    Attributes:
        longer: du of the first over that of the second.
        shorter: dv of the first over that of the second.
        turn: psi, of the first one's longer axis from that of the second, rad, above -pi/2 up to
            pi/2; 0 where one of both is round, which has no longer axis.
    """

    longer: float
    shorter: float
    turn: float

    @property
    def value(self) -> Floats:
        """All of it, shape (3,)."""
        return np.array(self)


def constellation_of(first: Blob, second: Blob) -> Constellation:
    """The constellation of two blobs."""
    longer, shorter = (first.extent / second.extent).tolist()
    axes = first.orientation, second.orientation
    turn = 0.0 if axes[0] is None or axes[1] is None else half_turn(axes[0] - axes[1])
    return Constellation(longer, shorter, turn)


def half_turn(angle: float) -> float:
    """An angle modulo half a turn, rad, above -pi/2 up to pi/2."""
    return angle - math.pi * math.ceil(angle / math.pi - 0.5)

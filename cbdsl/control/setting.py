"""Constants of a robot that a controller's potential may depend on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.kinematics.kinematics import Frame
from cbdsl.numeric.arrays import Floats


class Setting(NamedTuple):
    """Constants of a robot, independent of its posture.

    Attributes:
        lower: Lower limits of the controller's joints, rad, shape (n,); may be infinite.
        upper: Upper limits, rad, shape (n,).
        components: Number of components of the feedback's value.
        rows: Number of rows of its Jacobian.
        cameras: Frames of the cameras (x forward, y left, z up), left before right, all in one
            frame that moves with them; empty if they move relative to each other.
        circular: True for joints whose whole turns do not count, shape (n,); may be empty.
    """

    lower: Floats
    upper: Floats
    components: int
    rows: int
    cameras: tuple[Frame, ...] = ()
    circular: NDArray[np.bool_] = np.zeros(0, dtype=bool)

"""What potentials know of the body: constants of the robot, never of its posture."""

from __future__ import annotations

from dataclasses import dataclass

from cbdsl.control.signal import Floats
from cbdsl.sensing.kinematics import Frame


@dataclass(frozen=True)
class Body:
    """The part of a robot that a controller acts with.

    Attributes:
        lower: lower limits of the controller's joints, rad, shape (n,); may be infinite.
        upper: upper limits, rad, shape (n,).
        cameras: the cameras' frames (x forward, y left, z up), left before right, all in one
            frame that moves with them; empty where they move relative to each other.
    """

    lower: Floats
    upper: Floats
    cameras: tuple[Frame, ...] = ()

"""Mount of two mirrored arms, and the posture that they rest in, as numbers that are searched."""

from __future__ import annotations

import math
import runpy
from dataclasses import astuple, dataclass, fields

import numpy as np

from cbdsl.api.control import Floats
from cbdsl.api.shipped import shipped_folder

SCRIPT = shipped_folder() / "robots" / "make_dexter.py"


@dataclass(frozen=True)
class ArmMount:
    """Mount of the right arm and its resting posture; the left arm is its mirror image.

    Attributes:
        forward, half, up: Place of joint 1 in the torso's frame, m; ``half`` to either side.
        swing: Angle of joint 1's axis from outward to forward, rad.
        lift: Angle of that axis above the horizontal plane, rad; -pi / 2 hangs the arm.
        roll: Angle about that axis, rad; at 0 joint 2 bends the arm towards the lift of the axis.
        elbow: Angle of the resting elbow, from below the line to the hand outward, rad.
        rest_forward, rest_out, rest_up: Place of the resting palm, m.
    """

    forward: float
    half: float
    up: float
    swing: float
    lift: float
    roll: float
    elbow: float
    rest_forward: float
    rest_out: float
    rest_up: float

    @property
    def shoulder(self) -> Floats:
        """Position of the right arm's joint 1, m, shape (3,)."""
        return np.array((self.forward, -self.half, self.up))

    @property
    def rest(self) -> Floats:
        """Position of the resting right palm, m, shape (3,)."""
        return np.array((self.rest_forward, -self.rest_out, self.rest_up))

    @property
    def axes(self) -> Floats:
        """Axes of the right arm's base in the torso's frame, columns, shape (3, 3)."""
        level = math.cos(self.lift)
        axis = np.array(
            (level * math.sin(self.swing), -level * math.cos(self.swing), math.sin(self.lift))
        )
        # ``aside`` is the derivative of the axis by the lift, a unit vector at right angles to it.
        steep = math.sin(self.lift)
        aside = np.array(
            (-steep * math.sin(self.swing), steep * math.cos(self.swing), math.cos(self.lift))
        )
        along = math.cos(self.roll) * aside + math.sin(self.roll) * np.cross(axis, aside)
        return np.stack((along, np.cross(axis, along), axis), axis=1)

    def urdf(self) -> str:
        """Return Dexter's model with its arms on the mount."""
        roll, pitch, yaw = angles_of(self.axes)
        made = runpy.run_path(str(SCRIPT))["dexter"]
        text: str = made((self.forward, self.half, self.up), (-roll, pitch, -yaw))
        return text


#: Bounds of the search: the least and the greatest value of each number of a mount.
BOUNDS = (
    ArmMount(-0.15, 0.10, 0.0, -1.57, -1.57, -3.14, -1.6, 0.05, 0.15, -0.25),
    ArmMount(0.20, 0.28, 0.40, 1.57, 1.57, 3.14, 2.4, 0.50, 0.60, 0.20),
)
NAMES = tuple(each.name for each in fields(ArmMount))
#: The mount of robots/dexter.urdf: hanging, with the hand beside the table.
TODAY = ArmMount(0.07, 0.17, 0.21, 0.0, -math.pi / 2, math.pi / 2, 0.0, 0.10, 0.55, -0.20)


def angles_of(axes: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw, rad, of axes as columns, shape (3, 3), as in URDF."""
    pitch = math.asin(min(1.0, max(-1.0, -axes[2, 0])))
    # At a pitch of 90 deg, roll and yaw turn about the same axis, and the roll is set to 0.
    if abs(axes[2, 0]) > 1.0 - 1e-9:
        return 0.0, pitch, math.atan2(-axes[0, 1], axes[1, 1])
    return (
        math.atan2(axes[2, 1], axes[2, 2]),
        pitch,
        math.atan2(axes[1, 0], axes[0, 0]),
    )


def spread_over(count: int, rng: np.random.Generator) -> list[ArmMount]:
    """Return mounts all over the bounds, one in each of ``count`` slices of every number."""
    low, high = (np.array(astuple(bound)) for bound in BOUNDS)
    # Latin hypercube (McKay, Beckman and Conover, 1979): each number covers its range evenly,
    # without a grid over all ten numbers.
    slices = np.stack([rng.permutation(count) for _ in NAMES], axis=1)
    values = low + (high - low) * (slices + rng.random(slices.shape)) / count
    return [ArmMount(*row) for row in values.tolist()]


def near(mount: ArmMount, width: float, rng: np.random.Generator) -> ArmMount:
    """Return a mount near another one, within the bounds.

    Args:
        mount: Mount to vary.
        width: Standard deviation, as a part of the bounds' distance.
        rng: Random generator.
    """
    low, high = (np.array(astuple(bound)) for bound in BOUNDS)
    values = np.array(astuple(mount)) + width * (high - low) * rng.normal(size=len(NAMES))
    # Mounts that are turned about their axis have no end.
    turn = NAMES.index("roll")
    values[turn] = (values[turn] + math.pi) % (2 * math.pi) - math.pi
    return ArmMount(*np.minimum(np.maximum(values, low), high).tolist())

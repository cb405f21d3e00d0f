"""Contact places: where fingertips touch, from their load cells alone.

A contact on a convex tip without friction about its normal lies on the line along which force and
torque act, where that leaves the tip (intrinsic contact sensing, Bicchi, Salisbury and Brock 1993).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.signals import Signals

Floats = NDArray[np.float64]


def contact_places(signals: Signals, hand: str, radius: float) -> Floats:
    """Places at which the fingertips of a hand touch something, in the newest posture.

    Args:
        signals: of the robot.
        hand: with load cells in the middles of round fingertips.
        radius: of the fingertips, m.

    Returns:
        Places, m, world frame, shape (k, 3), for each of the k fingertips in contact.
    """
    touch, cells = signals.touch, signals.robot.load_cells[hand]
    signals.kinematics.place()
    first, last = touch.span(hand)
    places = [
        signals.kinematics.frame(cell.link).position + on_ball(load, radius)
        for cell, load, feels in zip(
            cells.values(), touch.loads[first:last], touch.feeling[first:last], strict=True
        )
        if feels
    ]
    return np.array(places).reshape(-1, 3)


def on_ball(load: Floats, radius: float) -> Floats:
    """Place at which a ball presses on something, from its middle.

    Args:
        load: force and torque that it exerts, about its middle, N and N m, shape (6,).
        radius: of the ball, m.

    Returns:
        Place, m, in the axes of the load, shape (3,).
    """
    force, torque = load[:3], load[3:]
    size = float(np.linalg.norm(force))
    # The point of the line of action that is nearest to the middle.
    foot: Floats = np.cross(force, torque) / size**2
    off = float(np.linalg.norm(foot))
    if off >= radius:  # noise, or a torque about the normal
        nearest: Floats = foot * (radius / off)
        return nearest
    place: Floats = foot + math.sqrt(radius**2 - off**2) * force / size
    return place

"""Contact places on fingertips, computed from their load cells alone.

Force and torque of a contact act along a line if there is no friction about the normal. On a convex
tip, the contact lies at the point at which this line leaves the tip (intrinsic contact sensing,
Bicchi, Salisbury and Brock 1993).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.sensing import Signals

Floats = NDArray[np.float64]


def contact_places(signals: Signals, hand: str, radius: float) -> Floats:
    """Return the places at which fingertips of a hand are in contact, in the newest posture.

    Args:
        signals: Signals of the robot.
        hand: Name of a hand with load cells in the middles of round fingertips.
        radius: Radius of the fingertips, m.

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
    """Return the place of a contact on a ball, from its middle.

    Args:
        load: Force and torque that the ball exerts, about its middle, N and N m, shape (6,).
        radius: Radius of the ball, m.

    Returns:
        Place, m, in the axes of the load, shape (3,).
    """
    # Without friction about the normal, the torque t about the middle is r x f at the contact r:
    #     f x t = f x (r x f) = r |f|^2 - f (r f),   so that   r = f x t / |f|^2 + c f.
    # The radius |r| determines c up to its sign. A ball only pushes, so that the contact lies ahead
    # of the middle in the direction of the force that the ball exerts.
    force, torque = load[:3], load[3:]
    size = float(np.linalg.norm(force))
    # The point of the line of action nearest to the middle.
    foot: Floats = np.cross(force, torque) / size**2
    off = float(np.linalg.norm(foot))
    if off >= radius:  # noise, or a torque about the normal
        nearest: Floats = foot * (radius / off)
        return nearest
    place: Floats = foot + math.sqrt(radius**2 - off**2) * force / size
    return place

"""Contact places on round fingertips, computed from their load cells; compiled.

Force and torque of a contact act along a line if there is no friction about the normal. On a convex
tip, the contact lies at the point at which this line leaves the tip (intrinsic contact sensing,
Bicchi, Salisbury and Brock 1993).
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.numeric.vector import add, cross, norm, scale


@compiled_once
def add_contact(load: Floats, radius: float, place: Floats) -> None:
    """Displace the middle of a fingertip to its contact.

    Args:
        load: Force and torque that the fingertip exerts, about its middle, N and N m, shape (6,).
        radius: Radius of the fingertip, m.
        place: Middle of the fingertip, m, in the axes of the load, shape (3,); becomes the place of
            the contact.
    """
    size = norm(load[:3])
    if size == 0.0:
        return
    # The point of the line of action nearest to the middle.
    foot = np.empty(3)
    cross(load[:3], load[3:], foot)
    scale(foot, 1.0 / size**2)
    off = norm(foot)
    if off >= radius:  # noise, or a torque about the normal
        add(place, foot, radius / off if off > 0.0 else 0.0)
        return
    add(place, foot, 1.0)
    add(place, load[:3], math.sqrt(radius**2 - off**2) / size)

"""Range-limit potential (Section 3.1.3 a, Eq 3.3 and 3.4).

phi = sum_i 1 - cos g_i, with g_i from -pi/2 to pi/2 between a joint's limits. Since
1 - cos g = (2 sin(g/2))^2 / 2, phi is half the square of r_i = 2 sin(g_i / 2). Those coordinates
have a Jacobian of full rank at the centre, where the gradient of phi vanishes.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.potential import Potential, potential
from cbdsl.control.setting import Setting
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the range potential of a controller between its joints' limits.

    Raises:
        ValueError: If a range is empty or unbounded.
    """
    return between(setting.lower, setting.upper)


def between(lower: Floats, upper: Floats) -> Potential:
    """Return the range potential between limits, rad, shape (m,)."""
    span = upper - lower
    endless = np.isinf(span)
    if endless.all() or not (span > 0).all():
        raise ValueError("a range potential needs finite joint limits, lower below upper")
    # A joint that turns without end has nothing to keep away from.
    centres = np.where(endless, 0.0, 0.5 * (np.where(endless, 0.0, lower) + upper))
    parameters = np.concatenate((centres, np.where(endless, 0.0, np.pi / span)))
    return Potential(distance_from_centre, len(span), parameters=parameters)


@potential
def distance_from_centre(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return phi of joint angles; parameters: centres of their ranges, rad, and g per angle."""
    phi, size = 0.0, len(residual)
    for i in range(size):
        per_angle = parameters[size + i]
        half_angle = 0.5 * per_angle * (value[i] - parameters[i])
        residual[i] = -2.0 * math.sin(half_angle)
        slope[i, i] = math.cos(half_angle) * per_angle
        phi += 0.5 * residual[i] * residual[i]
    return phi

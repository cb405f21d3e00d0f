"""Potential that keeps a point out of a ball around its reference."""

import math

import numpy as np

from cbdsl.extend.potential import (
    Condition,
    Controller,
    Floats,
    Navigation,
    Potential,
    PotentialType,
    Setting,
    potential,
)

_RADIUS = 0.15  # m

KEEP_OUT = PotentialType(
    name="keep_out",
    symbol="φ_k",
    equation="none",
    accepts=frozenset({"position"}),
    reference=True,
    zero_minimum=True,
    residual=True,
    navigation=Navigation(
        Condition.NOT_MET, Condition.NOT_MET, Condition.MET, Condition.NOT_MET, "outside the centre"
    ),
    implementation="demo.keep_out:build",
    factors=1,
)


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the potential of a controller."""
    return Potential(depth, 1, parameters=np.array([_RADIUS]))


@potential
def depth(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the square of the depth in the ball; parameter: its radius, m."""
    square = 0.0
    for i in range(3):
        square += (value[i] - reference[i]) ** 2
    distance = math.sqrt(square)
    residual[0] = max(parameters[0] - distance, 0.0)
    for i in range(3):
        slope[0, i] = (value[i] - reference[i]) / distance if residual[0] > 0.0 else 0.0
    return 0.5 * residual[0] * residual[0]

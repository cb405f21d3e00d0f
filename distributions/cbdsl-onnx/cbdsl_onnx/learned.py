"""Potential of a network's output: half the square of the requested displacement."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.extend.document import ModelSignal, Resource
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
from cbdsl_onnx.plan import NetworkPlan

_TYPES = frozenset({"configuration", "position", "heading", "length", "force", "torque"})

# The law moves the feedback by half of the residual per time constant 1 / gain: Newton's step on
# phi (Eq 3.18). A residual of 2 v / gain thus gives the velocity v.
_NEWTON = 2.0

LEARNED = PotentialType(
    name="learned",
    symbol="φ_n",
    equation="after Eq 3.1",
    accepts=_TYPES,
    reference=True,
    zero_minimum=True,
    residual=True,
    navigation=Navigation(
        Condition.NOT_MET,
        Condition.NOT_MET,
        Condition.NOT_MET,
        Condition.NOT_MET,
        "outputs of a network, which nothing is known of",
    ),
    implementation="cbdsl_onnx.learned:build",
)


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the potential of a controller that follows a network."""
    size, scale = controller.feedback.type.size, 1.0
    periods = np.full(size, np.inf)
    if controller.feedback.type.name == "configuration" and len(setting.circular) == size:
        periods[setting.circular] = 2.0 * math.pi
    reference = controller.reference
    if isinstance(reference, Resource) and isinstance(reference.source, ModelSignal):
        plan = reference.source.data
        if isinstance(plan, NetworkPlan) and plan.output.gives == "velocity":
            scale = _NEWTON / controller.gain
    parameters = np.concatenate([[scale], periods])
    return Potential(requested, size, parameters=parameters, identity=True)


@potential
def requested(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the square of the scaled difference; parameters: the scale, and periods, rad."""
    phi = 0.0
    for i in range(len(residual)):
        apart, period = reference[i] - value[i], parameters[1 + i]
        if math.isfinite(period):
            apart -= period * round(apart / period)
        residual[i] = parameters[0] * apart
        phi += 0.5 * residual[i] * residual[i]
    return phi

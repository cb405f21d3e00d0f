"""Potential of a network's output: half the square of the requested displacement.

A controller is at rest once its potential stays the same. The reference of a network moves with the
feedback: at a constant velocity the potential also stays the same, but the controller is not at
rest. A watch of the feedback therefore adds its motion to the criterion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

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
from cbdsl_onnx.plan import SUBTRACTED, NetworkPlan

# The law moves the feedback by half of the residual per time constant 1 / gain: Newton's step on
# phi (Eq 3.18). A residual of 2 v / gain thus gives the velocity v.
_NEWTON = 2.0

#: Share of the requested displacement that a moving feedback covers in a tick, at least.
_MOVING = 2e-3

LEARNED = PotentialType(
    name="learned",
    symbol="φ_n",
    equation="after Eq 3.1",
    accepts=frozenset(SUBTRACTED),
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
    parameters, rest = np.concatenate([[scale], periods]), controller.quiescence
    # A requested displacement within the range of rest is noise, and no motion towards a reference.
    watch = _MotionWatch(math.sqrt(2.0 * rest.rate * rest.window) / scale)
    return Potential(requested, size, parameters=parameters, identity=True, prepare=watch)


class _MotionWatch:
    """Watch of a feedback that follows its reference.

    Args:
        least: Requested displacement up to which motion is ignored, in the feedback's unit.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self._last: Floats | None = None

    def __call__(
        self, value: Floats, goal: Floats, obstacles: Sequence[object], parameters: Floats
    ) -> bool:
        """Return whether the feedback has moved since the preceding tick."""
        moved = 0.0 if self._last is None else float(np.linalg.norm(value - self._last))
        requested = float(np.linalg.norm(goal - value))
        self._last = value.copy()
        return requested > self._least and moved > _MOVING * requested


@potential
def requested(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared scaled difference; parameters: scale, and periods."""
    phi = 0.0
    for i in range(len(residual)):
        apart, period = reference[i] - value[i], parameters[1 + i]
        if math.isfinite(period):
            apart -= period * round(apart / period)
        residual[i] = parameters[0] * apart
        phi += 0.5 * residual[i] * residual[i]
    return phi

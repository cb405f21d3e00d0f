"""One-sided quadratic potentials: a bound that is met leaves its task coordinates free.

``at_most`` is phi = e . e / 2 with e the excess of the feedback over its reference in each
component, and 0 in a component that does not exceed it. ``at_least`` is the same with the
shortfall. A component that obeys its bound is free: lower levels move it up to the bound.
"""

from __future__ import annotations

import numpy as np

from cbdsl.control.potential import Potential, potential
from cbdsl.control.setting import Setting
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller


def build_upper(controller: Controller, setting: Setting) -> Potential:
    """Return the potential of a feedback that is to be at most its reference."""
    return bound(_components(controller), 1.0)


def build_lower(controller: Controller, setting: Setting) -> Potential:
    """Return the potential of a feedback that is to be at least its reference."""
    return bound(_components(controller), -1.0)


def bound(components: tuple[int, ...], side: float) -> Potential:
    """Return the potential of some components.

    Args:
        components: Indices of the components.
        side: 1 for an upper bound, -1 for a lower one.
    """
    parameters = np.array([side, *map(float, components)])
    return Potential(excess, len(components), parameters=parameters, side=side)


def _components(controller: Controller) -> tuple[int, ...]:
    kind = controller.feedback.type
    axes = controller.axes or tuple(range(kind.dimension))
    return tuple(kind.dimension * factor + axis for factor in range(kind.factors) for axis in axes)


@potential
def excess(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return half the squared excess; parameters: the side, then the indices of the components."""
    side, phi = parameters[0], 0.0
    for i in range(len(residual)):
        component = int(parameters[i + 1])
        error = reference[component] - value[component]
        slope[i, component] = 1.0
        if side * error < 0.0:
            residual[i] = error
            phi += 0.5 * error * error
    return phi

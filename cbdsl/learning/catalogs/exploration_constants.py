"""Constants that all explorations have."""

from __future__ import annotations

from typing import Annotated, Literal

from cbdsl.documents.document import Count, Section, quantity
from cbdsl.numeric.affordance_model import Measure


class ExplorationConstants(Section):
    """Constants that all explorations have (Sections 6.1 and 6.2)."""

    alpha: Annotated[float, quantity(gt=0, le=1)] = 0.3
    """Step size of the value's update."""
    cost: Annotated[float, quantity(ge=0, lt=1)] = 0.05
    """Cost rho of every action but noop."""
    prior: Annotated[float, quantity(gt=0)] = 1.0
    """As how many samples the prior of a model counts."""
    units: Literal["workspace", "si"] = "workspace"
    """Deviations of the prior: 3 cm, 0.1 rad, 1 l and so on, or 1 in SI."""
    measure: Measure = "spread"
    """Variance of a covariance: the spread, a trace that depends neither on the frame's origin nor
    on the signs of its axes; or the sum of all its elements, as the source has it, its trace, or
    the d-th root of its determinant."""
    habituated: Annotated[float, quantity(gt=0, le=1)] = 0.1
    """Below this change of its variance, relative to the largest so far, a model is habituated."""
    least: Count = 3
    """Times that each action is taken at least before an exploration is over."""
    longest: Annotated[float, quantity("time", gt=0, le=3600)] = 60.0
    """Time after which an action that is not over has failed."""

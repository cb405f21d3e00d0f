"""Internal models learned from rewarded configurations: Pr(tau | sigma, reward) (Section 4.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.learning.constants import Form


def learned_density(
    samples: Sequence[Sequence[float]], form: Form, bandwidth: float, prior: float
) -> Kernel | Gaussian:
    """The density of rewarded configurations, mixed with the uniform one that it started as.

    What was never rewarded stays possible, and becomes the less likely, the more is known.

    Args:
        samples: the configurations, rad, at least one, each with one angle a joint.
        form: a Gaussian kernel around each of them, or one Gaussian a joint.
        bandwidth: standard deviation of the kernels, and the smallest one of a Gaussian, rad.
        prior: as how many samples the uniform density counts.
    """
    uniform = prior / (prior + len(samples))
    angles = np.array(samples, dtype=float)
    joints = angles.shape[1]
    if form == "kernel":
        rows = tuple(_rounded(row) for row in angles)
        return Kernel(form="kernel", samples=rows, bandwidth=(bandwidth,) * joints, uniform=uniform)
    deviation = np.maximum(angles.std(axis=0), bandwidth)
    mean = _rounded(angles.mean(axis=0))
    return Gaussian(form="gaussian", mean=mean, deviation=_rounded(deviation), uniform=uniform)


def _rounded(angles: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    """To microradians, so that what is written and what was drawn from while learning agree."""
    return tuple(round(float(angle), 6) for angle in angles)

"""Internal models learned from rewarded configurations: Pr(tau | sigma, reward) (Section 4.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.learning.constants import Form


def learned_density(
    samples: Sequence[Sequence[float]], form: Form, bandwidth: float, prior: float
) -> Kernel | Gaussian:
    """Return the density of rewarded configurations, mixed with the initial uniform density.

    Configurations without reward stay possible, and become less likely with more samples.

    Args:
        samples: Configurations, rad, shape (n, joints), n >= 1.
        form: ``kernel`` for a Gaussian around each configuration, ``gaussian`` for one per joint.
        bandwidth: Standard deviation of the kernels, smallest one of a Gaussian, rad.
        prior: Weight of the uniform density, in samples.
    """
    # Model: with n samples tau_i, bandwidth b and prior weight p,
    #     Pr(tau | sigma, reward) = u U(tau) + (1 - u) / n sum_i N(tau; tau_i, b^2),
    # where U is the uniform density over the joint ranges, and u = p / (p + n) its share.
    uniform = prior / (prior + len(samples))
    angles = np.array(samples, dtype=float)
    joints = angles.shape[1]
    if form == "kernel":
        rows = tuple(_rounded(row) for row in angles)
        return Kernel(form="kernel", samples=rows, bandwidth=(bandwidth,) * joints, uniform=uniform)
    # A single sample has a deviation of 0.
    deviation = np.maximum(angles.std(axis=0), bandwidth)
    mean = _rounded(angles.mean(axis=0))
    return Gaussian(form="gaussian", mean=mean, deviation=_rounded(deviation), uniform=uniform)


def _rounded(angles: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    """Round to microradians, so that written and sampled densities agree."""
    return tuple(round(float(angle), 6) for angle in angles)

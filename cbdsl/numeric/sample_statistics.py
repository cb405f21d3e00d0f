"""Mean and scatter of samples, updated one sample at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cbdsl.numeric.arrays import Floats


@dataclass(frozen=True)
class SampleStatistics:
    """Sufficient statistics of a multivariate Gaussian; immutable.

    Attributes:
        weight: Number of samples; for a prior its weight in samples.
        mean: Mean of the samples, shape (d,).
        scatter: Sum of the outer products of their deviations from the mean, shape (d, d).
    """

    weight: float
    mean: Floats
    scatter: Floats

    @classmethod
    def empty(cls, size: int) -> SampleStatistics:
        """Return statistics without samples, for the given number of components."""
        return cls(0.0, np.zeros(size), np.zeros((size, size)))

    @classmethod
    def of(cls, weight: float, mean: Floats, covariance: Floats) -> SampleStatistics:
        """Return statistics with the given weight, mean and covariance."""
        return cls(weight, mean, weight * covariance)

    def updated(self, sample: Floats) -> SampleStatistics:
        """Return statistics with one more sample, by Welford's update, without cancellation."""
        weight = self.weight + 1.0
        before = sample - self.mean
        mean = self.mean + before / weight
        scatter = self.scatter + np.outer(before, before) * (self.weight / weight)
        return SampleStatistics(weight, mean, scatter)

    def merged(self, other: SampleStatistics) -> SampleStatistics:
        """Return statistics of the samples of both."""
        weight = self.weight + other.weight
        if not weight:
            return self
        apart = other.mean - self.mean
        mean = self.mean + apart * (other.weight / weight)
        between = np.outer(apart, apart) * (self.weight * other.weight / weight)
        return SampleStatistics(weight, mean, self.scatter + other.scatter + between)

    @property
    def covariance(self) -> Floats:
        """Mean outer product of the deviations, shape (d, d); zero without samples."""
        return self.scatter / self.weight if self.weight else self.scatter

    def log_density(self, point: Floats) -> float:
        """Return the logarithm of the Gaussian's density at a point.

        Raises:
            numpy.linalg.LinAlgError: If the covariance is not positive definite.
        """
        factor = np.linalg.cholesky(self.covariance)
        standard = np.linalg.solve(factor, point - self.mean)
        volume = float(np.log(np.diag(factor)).sum())
        constant = 0.5 * len(self.mean) * math.log(2 * math.pi)
        return -0.5 * float(standard @ standard) - volume - constant

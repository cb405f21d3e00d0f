"""Affordance model: the features with which an action is rewarded, and how sure that is (6.1)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.sample_statistics import SampleStatistics

Floats = NDArray[np.float64]
Measure = Literal["sum", "trace", "determinant", "spread"]

# Deviations of a prior that counts for something in a robot's workspace, by unit.
_WORKSPACE: Mapping[str, float] = {
    "m": 0.03, "rad": 0.1, "1": 0.1, "m/s": 0.1, "rad/s": 0.1, "m^3": 1e-3,
}  # fmt: skip

# Of the variance of the prior, in which densities that predict are spread at least.
_LEAST_SPREAD = 0.01


def _sum(covariance: Floats) -> float:
    return float(covariance.sum())


def _trace(covariance: Floats) -> float:
    return float(np.trace(covariance))


def _determinant(covariance: Floats) -> float:
    sign, logarithm = np.linalg.slogdet(covariance)
    return math.exp(float(logarithm) / len(covariance)) if sign > 0 else 0.0


#: How much a covariance varies, as one number: the source adds all of its elements up. That sum
#: depends on the signs of the axes, and each of the first three on the frame's origin, because the
#: prior's mean is there. A spread is the trace for a prior whose mean is that of the samples.
MEASURES: Mapping[str, Callable[[Floats], float]] = {
    "sum": _sum,
    "trace": _trace,
    "determinant": _determinant,
    "spread": _trace,
}


def deviation_of(unit: str) -> float:
    """Deviation of a component of this unit that counts for something in a workspace."""
    return _WORKSPACE.get(unit, 1.0)


@dataclass(frozen=True, eq=False)
class AffordanceModel:
    """Knowledge of one action: Pr(f | reward, a), and with it all that follows from counts.

    Samples are in SI; the prior is a Gaussian of zero mean whose deviation is the ``scale`` of
    each component, and counts as ``prior`` samples.

    Attributes:
        scale: of each component of the features, in its unit, shape (d,).
        prior: as how many samples the prior counts.
        tried: how often the action was taken.
        successes: how often it was rewarded, features or not.
        rewarded: features when it was rewarded.
        unrewarded: features when it was not.
    """

    scale: Floats
    prior: float
    tried: int
    successes: int
    rewarded: SampleStatistics
    unrewarded: SampleStatistics

    @classmethod
    def fresh(cls, scale: Floats, prior: float = 1.0) -> AffordanceModel:
        """Model of an action that was never taken."""
        nothing = SampleStatistics.empty(len(scale))
        return cls(scale, prior, 0, 0, nothing, nothing)

    def updated(self, features: Floats | None, *, rewarded: bool) -> AffordanceModel:
        """Model after the action was taken once more.

        Args:
            features: observed at its activation, shape (d,); ``None`` while one was undefined.
            rewarded: whether it was rewarded.
        """
        counted = replace(self, tried=self.tried + 1, successes=self.successes + rewarded)
        if features is None:
            return counted
        if rewarded:
            return replace(counted, rewarded=self.rewarded.updated(features))
        return replace(counted, unrewarded=self.unrewarded.updated(features))

    def variance(self, measure: str = "sum") -> float:
        """Variance of Pr(f | reward, a) in units of the scale, which habituates (Eq 6.3)."""
        samples = _scaled(self.rewarded, self.scale)
        if measure == "spread":
            samples = replace(samples, mean=np.zeros(len(self.scale)))
        return MEASURES[measure](_prior(len(self.scale), self.prior).merged(samples).covariance)

    @property
    def reward_probability(self) -> float:
        """Pr(reward | a), by Laplace's rule: a half before anything was tried."""
        return (self.successes + 1) / (self.tried + 2)

    def reward_given(self, features: Floats) -> float:
        """Pr(reward | f, a), by Bayes' rule from the features with reward and without.

        It goes back to Pr(reward | a) where the features are as unlikely with reward as without.
        """
        prior = self.reward_probability
        if self.rewarded.weight == 0 or self.unrewarded.weight == 0:
            return prior
        with_, without = (
            self._predictive(each).log_density(features)
            for each in (self.rewarded, self.unrewarded)
        )
        odds = math.log(prior / (1 - prior)) + with_ - without
        return 1 / (1 + math.exp(-odds)) if odds > -700 else 0.0

    def distance(self, features: Floats) -> float:
        """Mahalanobis distance of features from those with reward."""
        if self.rewarded.weight == 0:
            return 0.0
        known = self._predictive(self.rewarded)
        apart = features - known.mean
        return math.sqrt(float(apart @ np.linalg.solve(known.covariance, apart)))

    def log_density(self, features: Floats) -> float:
        """Logarithm of Pr(f | reward, a) per unit of the features; -inf without samples."""
        if self.rewarded.weight == 0:
            return -math.inf
        return self._predictive(self.rewarded).log_density(features)

    def over(self, components: Sequence[int]) -> AffordanceModel:
        """The model of some of the features' components."""
        chosen = np.array(components, dtype=np.int64)
        return replace(
            self,
            scale=self.scale[chosen],
            rewarded=_part(self.rewarded, chosen),
            unrewarded=_part(self.unrewarded, chosen),
        )

    def density(self, features: Floats) -> float:
        """Pr(f | a) per unit of the features: the mixture over reward and none."""
        prior = self.reward_probability
        parts = ((prior, self.rewarded), (1 - prior, self.unrewarded))
        known = [(share, each) for share, each in parts if each.weight > 0]
        total = sum(share for share, _ in known)
        return sum(
            share / total * math.exp(self._predictive(each).log_density(features))
            for share, each in known
        )

    def _predictive(self, samples: SampleStatistics) -> SampleStatistics:
        """Gaussian of samples, with a spread of the prior's around their own mean.

        Few samples lie in a plane, which would make all others impossible. As many samples as
        there are components are needed before their own spread counts more than the prior's.
        """
        own = samples.covariance
        weight, count = len(self.scale) / 2, samples.weight
        spread = np.diag(self.scale**2)
        mixed = (count * own + weight * spread) / (count + weight)
        return SampleStatistics.of(count, samples.mean, mixed + _LEAST_SPREAD * spread)


def _prior(size: int, weight: float) -> SampleStatistics:
    return SampleStatistics.of(weight, np.zeros(size), np.eye(size))


def _part(samples: SampleStatistics, chosen: NDArray[np.int64]) -> SampleStatistics:
    """Gaussian of some components of the samples."""
    scatter = samples.scatter[np.ix_(chosen, chosen)]
    return SampleStatistics(samples.weight, samples.mean[chosen], scatter)


def _scaled(samples: SampleStatistics, scale: Floats) -> SampleStatistics:
    """Gaussian of the same samples, each component in units of its scale."""
    return SampleStatistics(
        samples.weight, samples.mean / scale, samples.scatter / np.outer(scale, scale)
    )

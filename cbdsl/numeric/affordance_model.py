"""Affordance model: features with which an action is rewarded, with their uncertainty (6.1)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.sample_statistics import SampleStatistics

Measure = Literal["sum", "trace", "determinant", "spread"]

# Significant deviations in a robot's workspace, for priors, by unit.
_WORKSPACE: Mapping[str, float] = {
    "m": 0.03, "rad": 0.1, "1": 0.1, "m/s": 0.1, "rad/s": 0.1, "m^3": 1e-3,
}  # fmt: skip

# Smallest spread of predictive densities, in parts of the prior's variance.
_LEAST_SPREAD = 0.01
# Largest excess of a Mahalanobis distance of familiar features over its usual value, which is the
# root of the number of components. Gaussian samples exceed it in less than one of 10,000 cases.
_FAMILIAR = 4.0


# Weight of the base rate beside the features, in trials, and covariance of the prior of features in
# squares of the scale. Both have the least mean Brier score in `test_reward_given_of_few_trials`.
_BASE_TRIALS = 4.0
_PRIOR_SPREAD = 4.0


def _sum(covariance: Floats) -> float:
    return float(covariance.sum())


def _trace(covariance: Floats) -> float:
    return float(np.trace(covariance))


def _determinant(covariance: Floats) -> float:
    sign, logarithm = np.linalg.slogdet(covariance)
    return math.exp(float(logarithm) / len(covariance)) if sign > 0 else 0.0


#: Measures of a covariance's size. The source adds up all of its elements. That sum depends on the
#: signs of the axes. Each of the first three depends on the frame's origin, because the prior's
#: mean is there. The spread is the trace with a prior whose mean is that of the samples.
MEASURES: Mapping[str, Callable[[Floats], float]] = {
    "sum": _sum,
    "trace": _trace,
    "determinant": _determinant,
    "spread": _trace,
}


def deviation_of(unit: str) -> float:
    """Return the significant deviation of a component of this unit in a workspace."""
    return _WORKSPACE.get(unit, 1.0)


@dataclass(frozen=True, eq=False)
class AffordanceModel:
    """Knowledge of one action: Pr(f | reward, a), and counts of trials and rewards.

    Samples are in SI. The prior is a Gaussian of zero mean whose deviation is the ``scale`` of each
    component. It counts as ``prior`` samples.

    Attributes:
        scale: Deviation of each component of the features in the prior, in its unit, shape (d,).
        prior: Weight of the prior, in samples.
        tried: Number of trials.
        successes: Number of rewarded trials, with or without features.
        rewarded: Statistics of the features of rewarded trials.
        unrewarded: Statistics of the features of unrewarded trials.
    """

    scale: Floats
    prior: float
    tried: int
    successes: int
    rewarded: SampleStatistics
    unrewarded: SampleStatistics

    @classmethod
    def fresh(cls, scale: Floats, prior: float = 1.0) -> AffordanceModel:
        """Return the model of an action without trials."""
        nothing = SampleStatistics.empty(len(scale))
        return cls(scale, prior, 0, 0, nothing, nothing)

    def updated(self, features: Floats | None, *, rewarded: bool) -> AffordanceModel:
        """Return the model after one more trial of the action.

        Args:
            features: Features at its activation, shape (d,); ``None`` if one was undefined.
            rewarded: True if it was rewarded.
        """
        counted = replace(self, tried=self.tried + 1, successes=self.successes + rewarded)
        if features is None:
            return counted
        if rewarded:
            return replace(counted, rewarded=self.rewarded.updated(features))
        return replace(counted, unrewarded=self.unrewarded.updated(features))

    def variance(self, measure: str = "sum") -> float:
        """Return the habituating variance of Pr(f | reward, a) in units of the scale (Eq 6.3)."""
        samples = _scaled(self.rewarded, self.scale)
        if measure == "spread":
            samples = replace(samples, mean=np.zeros(len(self.scale)))
        return MEASURES[measure](_prior(len(self.scale), self.prior).merged(samples).covariance)

    def change_to(self, other: AffordanceModel, measure: str = "sum") -> float:
        """Return the change of the variance to a later model (Eq 6.3).

        That of the spread is relative, ln(after / before): it depends on no unit either. An
        absolute change would shrink with the size of the first one, which is that of the prior.

        Args:
            other: Later model of the same features.
            measure: Name of the measure of the variance.
        """
        before, after = self.variance(measure), other.variance(measure)
        if measure == "spread":
            return abs(math.log(after / before))
        return abs(after - before)

    @property
    def reward_probability(self) -> float:
        """Probability Pr(reward | a), by Laplace's rule: 0.5 without trials."""
        return (self.successes + 1) / (self.tried + 2)

    def knows(self, features: Floats) -> bool:
        """Return whether features are near those of a trial, with reward or without.

        Elsewhere nothing was tried, and a reward is unknown. A model without any features holds
        everywhere.
        """
        tried = [each for each in (self.rewarded, self.unrewarded) if each.weight > 0]
        most = math.sqrt(len(self.scale)) + _FAMILIAR
        return not tried or any(self._apart(each, features) <= most for each in tried)

    def reward_given(self, features: Floats) -> float:
        """Return Pr(reward | f, a), by Bayes' rule from the features with and without reward.

        The base rate counts as some more trials, so that few trials never predict certainty. It is
        0.5 where nothing was tried; see ``knows``.
        """
        if not self.knows(features):
            return 0.5
        base = self.reward_probability
        if self.rewarded.weight == 0 or self.unrewarded.weight == 0:
            return base
        with_, without = (
            self._log_posterior(each, features) for each in (self.rewarded, self.unrewarded)
        )
        odds = math.log(base / (1 - base)) + with_ - without
        by_features = 1 / (1 + math.exp(-odds)) if odds > -700 else 0.0
        return (self.tried * by_features + _BASE_TRIALS * base) / (self.tried + _BASE_TRIALS)

    # The posterior predictive density of a Gaussian of unknown mean and covariance is Student's t,
    # with a flat prior of the mean and the conjugate prior of the covariance (Murphy 2007). Its
    # tails are heavy for few samples: one failure says little about places at a distance.
    def _log_posterior(self, samples: SampleStatistics, features: Floats) -> float:
        """Return the log density of features, with the uncertainty of the samples' Gaussian."""
        size, count = len(self.scale), samples.weight
        freedom = count + 1
        spread = (_PRIOR_SPREAD * np.diag(self.scale**2) + samples.scatter) / count
        apart = features - samples.mean
        square = float(apart @ np.linalg.solve(spread, apart))
        return (
            math.lgamma((freedom + size) / 2)
            - math.lgamma(freedom / 2)
            - size / 2 * math.log(freedom * math.pi)
            - float(np.linalg.slogdet(spread)[1]) / 2
            - (freedom + size) / 2 * math.log1p(square / freedom)
        )

    def distance(self, features: Floats) -> float:
        """Return the Mahalanobis distance of features from the rewarded ones."""
        return 0.0 if self.rewarded.weight == 0 else self._apart(self.rewarded, features)

    def likeness(self, features: Floats) -> float:
        """Return the share of rewarded trials that are farther from their mean, by their Gaussian.

        The squared Mahalanobis distance of Gaussian samples is chi-squared.
        """
        from scipy.special import gammaincc  # slow to import

        if self.rewarded.weight == 0:
            return 0.0
        return float(gammaincc(len(self.scale) / 2.0, self.distance(features) ** 2 / 2.0))

    def _apart(self, samples: SampleStatistics, features: Floats) -> float:
        """Return the Mahalanobis distance of features from samples."""
        known = self._predictive(samples)
        apart = features - known.mean
        return math.sqrt(float(apart @ np.linalg.solve(known.covariance, apart)))

    def log_density(self, features: Floats) -> float:
        """Return log Pr(f | reward, a) per unit of the features; -inf without samples."""
        if self.rewarded.weight == 0:
            return -math.inf
        return self._predictive(self.rewarded).log_density(features)

    def over(self, components: Sequence[int]) -> AffordanceModel:
        """Return the model of some of the features' components."""
        chosen = np.array(components, dtype=np.int64)
        return replace(
            self,
            scale=self.scale[chosen],
            rewarded=_part(self.rewarded, chosen),
            unrewarded=_part(self.unrewarded, chosen),
        )

    def density(self, features: Floats) -> float:
        """Return Pr(f | a) per unit of the features: the mixture with and without reward."""
        prior = self.reward_probability
        parts = ((prior, self.rewarded), (1 - prior, self.unrewarded))
        known = [(share, each) for share, each in parts if each.weight > 0]
        total = sum(share for share, _ in known)
        return sum(
            share / total * math.exp(self._predictive(each).log_density(features))
            for share, each in known
        )

    def _predictive(self, samples: SampleStatistics) -> SampleStatistics:
        """Return the Gaussian of samples, mixed with the prior's spread around their own mean.

        A few samples lie in a plane, and their Gaussian would exclude all other values. The
        samples' own spread outweighs the prior's if their number exceeds half that of the
        components.
        """
        own = samples.covariance
        weight, count = len(self.scale) / 2, samples.weight
        spread = np.diag(self.scale**2)
        mixed = (count * own + weight * spread) / (count + weight)
        return SampleStatistics.of(count, samples.mean, mixed + _LEAST_SPREAD * spread)


def _prior(size: int, weight: float) -> SampleStatistics:
    return SampleStatistics.of(weight, np.zeros(size), np.eye(size))


def _part(samples: SampleStatistics, chosen: NDArray[np.int64]) -> SampleStatistics:
    """Return the Gaussian of some components of the samples."""
    scatter = samples.scatter[np.ix_(chosen, chosen)]
    return SampleStatistics(samples.weight, samples.mean[chosen], scatter)


def _scaled(samples: SampleStatistics, scale: Floats) -> SampleStatistics:
    """Return the Gaussian of the samples with each component in units of its scale."""
    return SampleStatistics(
        samples.weight, samples.mean / scale, samples.scatter / np.outer(scale, scale)
    )

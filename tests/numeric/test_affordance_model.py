"""Affordance models: statistics as numpy has them, positive definite, and Bayes' rule."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cbdsl.numeric.affordance_model import MEASURES, AffordanceModel
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.sample_statistics import SampleStatistics

SAMPLES = st.integers(1, 5).flatmap(
    lambda size: st.integers(1, 30).flatmap(
        lambda count: arrays(float, (count, size), elements=st.floats(-100, 100))
    )
)


def gaussian(samples: np.ndarray) -> SampleStatistics:
    own = SampleStatistics.empty(samples.shape[1])
    for sample in samples:
        own = own.updated(sample)
    return own


@settings(max_examples=60, deadline=None)
@given(SAMPLES)
def test_online_updates_equal_the_batch_mean_and_covariance(samples: np.ndarray) -> None:
    own = gaussian(samples)
    expected = np.atleast_2d(np.cov(samples.T, bias=True))
    assert own.weight == len(samples)
    np.testing.assert_allclose(own.mean, samples.mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(own.covariance, expected, atol=1e-8)


def test_large_means_lose_no_precision() -> None:
    samples = np.random.default_rng(7).normal(1e8, 1e-2, (500, 2))
    np.testing.assert_allclose(
        gaussian(samples).covariance, np.cov((samples - 1e8).T, bias=True), atol=1e-7
    )


@settings(max_examples=60, deadline=None)
@given(SAMPLES, st.integers(0, 30))
def test_two_halves_merge_to_the_whole(samples: np.ndarray, cut: int) -> None:
    whole = gaussian(samples)
    first, second = gaussian(samples[:cut]), gaussian(samples[cut:])
    merged = first.merged(second)
    np.testing.assert_allclose(merged.mean, whole.mean, atol=1e-9)
    np.testing.assert_allclose(merged.covariance, whole.covariance, atol=1e-8)


@settings(max_examples=60, deadline=None)
@given(SAMPLES)
def test_with_its_prior_every_model_varies_by_a_positive_amount(samples: np.ndarray) -> None:
    model = AffordanceModel.fresh(np.ones(samples.shape[1]))
    for sample in samples:
        model = model.updated(sample, rewarded=True)
        assert all(model.variance(measure) > 0 for measure in MEASURES)
        assert np.linalg.eigvalsh(model._predictive(model.rewarded).covariance).min() > 0


def test_prior_is_a_gaussian_of_zero_mean_and_unit_variance() -> None:
    model = AffordanceModel.fresh(np.array([0.1, 2.0, 1.0]))
    assert model.variance("sum") == model.variance("trace") == pytest.approx(3.0)
    assert model.variance("determinant") == pytest.approx(1.0)


def test_variance_change_falls_for_equal_samples_and_rises_for_new_ones() -> None:
    rng, model = np.random.default_rng(3), AffordanceModel.fresh(np.full(3, 0.1))
    variances = [model.variance()]

    def see(place: float) -> float:
        nonlocal model
        model = model.updated(rng.normal(place, 0.01, 3), rewarded=True)
        variances.append(model.variance())
        return abs(variances[-1] - variances[-2])

    changes = [see(0.5) for _ in range(25)]
    assert changes[-1] < 0.05 * max(changes)
    assert see(0.75) > 5 * changes[-1]


def test_failures_change_counts_and_not_the_model_of_reward() -> None:
    model = AffordanceModel.fresh(np.ones(2)).updated(np.array([1.0, 2.0]), rewarded=True)
    after = model.updated(np.array([5.0, 5.0]), rewarded=False).updated(None, rewarded=True)
    assert after.variance() == model.variance()
    assert (after.tried, after.successes, after.reward_probability) == (3, 2, 3 / 5)


def test_reward_given_features_follows_bayes_and_pr_of_features_sums_to_one() -> None:
    rng, model = np.random.default_rng(11), AffordanceModel.fresh(np.array([0.1]))
    for _ in range(200):
        model = model.updated(rng.normal(0.5, 0.05, 1), rewarded=True)
        model = model.updated(rng.normal(0.9, 0.05, 1), rewarded=False)
    near, between, far = (model.reward_given(np.array([x])) for x in (0.5, 0.7, 0.9))
    assert near > 0.99 and far < 0.01 and 0.3 < between < 0.7
    grid = np.linspace(-1, 2.5, 7001)
    total = sum(model.density(np.array([x])) for x in grid) * (grid[1] - grid[0])
    assert total == pytest.approx(1.0, abs=1e-3)


def test_action_that_never_failed_is_predicted_by_its_rate() -> None:
    model = AffordanceModel.fresh(np.ones(1))
    assert model.reward_given(np.zeros(1)) == 0.5
    for _ in range(8):
        model = model.updated(np.zeros(1), rewarded=True)
    assert model.reward_given(np.ones(1)) == 0.9
    # Nothing was tried there.
    assert model.reward_given(np.full(1, 50.0)) == 0.5


@given(
    arrays(float, (6, 3), elements=st.floats(-1.0, 1.0)),
    arrays(float, 3, elements=st.floats(-2.0, 2.0)),
    arrays(float, 3, elements=st.sampled_from([-1.0, 1.0])),
)
def test_variance_spread_does_not_depend_on_origin_and_axis_signs(
    samples: np.ndarray, origin: np.ndarray, signs: np.ndarray
) -> None:
    model = moved = AffordanceModel.fresh(np.full(3, 0.03))
    for sample in samples:
        model = model.updated(sample, rewarded=True)
        moved = moved.updated(signs * (sample - origin), rewarded=True)
        assert moved.variance("spread") == pytest.approx(model.variance("spread"), rel=1e-6)


@pytest.mark.parametrize("measure", ["sum", "trace", "determinant"])
def test_variance_of_the_other_measures_depends_on_the_origin(measure: str) -> None:
    """Their prior's mean is at the origin."""
    fresh = AffordanceModel.fresh(np.full(3, 0.03))
    near, far = (fresh.updated(np.full(3, x), rewarded=True) for x in (0.0, 1.0))
    assert far.variance(measure) > 10 * near.variance(measure)


@pytest.mark.parametrize("rewarded", [True, False])
def test_reward_given_unfamiliar_features_is_unknown(rewarded: bool) -> None:
    rng = np.random.default_rng(4)
    model = AffordanceModel.fresh(np.full(3, 0.03))
    for sample in rng.normal([0.6, -0.2, -0.3], 0.08, (50, 3)):
        model = model.updated(sample, rewarded=rewarded)
    near, far = np.array([0.65, -0.3, -0.25]), np.array([1.5, -0.2, -0.3])
    assert model.knows(near) and model.reward_given(near) == model.reward_probability
    assert not model.knows(far) and model.reward_given(far) == 0.5


def test_knows_nearly_all_samples_of_its_own_distribution() -> None:
    rng = np.random.default_rng(5)
    model = AffordanceModel.fresh(np.full(4, 0.03))
    samples = rng.multivariate_normal(np.zeros(4), np.diag([0.2, 0.1, 0.05, 0.01]), 40)
    for place, sample in enumerate(samples):
        model = model.updated(sample, rewarded=place % 3 > 0)
    fresh = rng.multivariate_normal(np.zeros(4), np.diag([0.2, 0.1, 0.05, 0.01]), 1000)
    assert sum(map(model.knows, fresh)) >= 995


def test_model_without_features_knows_everything() -> None:
    model = AffordanceModel.fresh(np.zeros(0)).updated(None, rewarded=True)
    assert model.knows(np.zeros(0))


def _is_near(place: float) -> float:
    return 0.95 if place < 0.5 else 0.1


def _is_reached(place: float) -> float:
    return 0.95 if place < 0.75 else 0.3


def _is_anywhere(place: float) -> float:
    return 0.8


@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize(
    ("chance", "most"), [(_is_near, 0.95), (_is_reached, 0.97), (_is_anywhere, 1.2)]
)
def test_reward_given_of_few_trials_scores_better_than_base_rate(
    size: int, chance: Callable[[float], float], most: float
) -> None:
    """Brier scores at held-out near and far places, of the models of eight trials."""
    rng = np.random.default_rng(11)

    def features() -> Floats:
        return np.array([rng.uniform(0.2, 0.9), rng.uniform(-0.3, 0.3), rng.normal(0.02, 3e-3)])

    own, base = [], []
    for _ in range(150):
        model = AffordanceModel.fresh(np.full(size, 0.03))
        for _ in range(8):
            seen = features()
            rewarded = bool(rng.random() < chance(float(seen[0])))
            model = model.updated(seen[:size], rewarded=rewarded)
        for _ in range(20):
            seen = features()
            outcome = float(rng.random() < chance(float(seen[0])))
            own.append((model.reward_given(seen[:size]) - outcome) ** 2)
            base.append((model.reward_probability - outcome) ** 2)
    # Where places do not matter, the model of few trials costs a little.
    assert np.mean(own) < most * np.mean(base)


def test_reward_given_of_eight_trials_is_never_certain() -> None:
    model = AffordanceModel.fresh(np.full(3, 0.03))
    for x in (0.30, 0.33, 0.36, 0.40, 0.44, 0.47, 0.50):
        model = model.updated(np.array([x, 0.0, 0.0]), rewarded=True)
    model = model.updated(np.array([0.62, 0.0, 0.0]), rewarded=False)
    for x in np.linspace(0.2, 0.8, 61):
        assert 0.1 < model.reward_given(np.array([x, 0.0, 0.0])) < 0.94

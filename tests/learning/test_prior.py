"""Densities of rewarded configurations, as programs draw from them."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.learning.accommodate import learned_density
from cbdsl.learning.constants import Form
from cbdsl.program.binding import density_source
from cbdsl.sensing.density import DensitySampler

FORMS: tuple[Form, ...] = ("kernel", "gaussian")
LOWER, UPPER = np.array([-1.7, -1.0]), np.array([1.7, 1.5])


def around(centre: tuple[float, float], count: int, spread: float) -> np.ndarray:
    return np.random.default_rng(3).normal(centre, spread, (count, 2))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("count", [1, 3, 50])
@pytest.mark.parametrize("prior", [0.0, 1.0, 10.0])
def test_uniform_density_counts_as_some_samples(form: Form, count: int, prior: float) -> None:
    density = learned_density(around((0, 0), count, 0.2).tolist(), form, 0.1, prior)
    assert density.uniform == pytest.approx(prior / (count + prior))


def test_gaussian_has_the_mean_and_deviation_of_the_samples() -> None:
    samples = around((0.4, -0.2), 30, 0.3)
    density = learned_density(samples.tolist(), "gaussian", 0.1, 1.0)
    assert isinstance(density, Gaussian)
    assert density.mean == pytest.approx(samples.mean(axis=0), abs=1e-6)
    assert density.deviation == pytest.approx(samples.std(axis=0), abs=1e-6)


def test_density_of_one_sample_has_a_deviation() -> None:
    density = learned_density([[0.4, -0.2]], "gaussian", 0.1, 1.0)
    assert isinstance(density, Gaussian)
    assert density.deviation == (0.1, 0.1)


def test_kernel_stands_at_each_sample() -> None:
    density = learned_density([[0.1, 0.2], [0.1, 0.2], [1.3, 0.4]], "kernel", 0.05, 1.0)
    assert isinstance(density, Kernel)
    assert density.samples == ((0.1, 0.2), (0.1, 0.2), (1.3, 0.4))
    assert density.bandwidth == (0.05, 0.05)


def test_density_of_two_places_has_two_peaks() -> None:
    front, window = around((0, 0.3), 30, 0.05), around((1.3, 0.2), 20, 0.02)
    density = learned_density(np.vstack([front, window]).tolist(), "kernel", 0.1, 1.0)
    sampler = DensitySampler(
        density_source("head", density), LOWER, UPPER, np.random.default_rng(0)
    )
    draws = np.array([sampler.draw() for _ in range(2000)])
    near = [np.linalg.norm(draws - centre, axis=1) < 0.4 for centre in ((0, 0.3), (1.3, 0.2))]
    assert near[0].mean() == pytest.approx(30 / 51, abs=0.06)
    assert near[1].mean() == pytest.approx(20 / 51, abs=0.06)

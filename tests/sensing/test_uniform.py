"""Uniform draws from the joint ranges."""

import numpy as np
import pytest

from cbdsl.sensing.density import UniformSampler

LOWER, UPPER = np.array([-1.7, -1.0]), np.array([1.7, 1.5])


def test_every_draw_is_uniform_over_the_box() -> None:
    samplers = [UniformSampler(LOWER, UPPER, np.random.default_rng(k)) for k in range(2000)]
    for _ in range(3):
        draws = np.array([sampler.draw() for sampler in samplers])
        assert (draws >= LOWER).all() and (draws <= UPPER).all()
        for column in range(2):
            share = (draws[:, column] - LOWER[column]) / (UPPER - LOWER)[column]
            counts = np.histogram(share, bins=10, range=(0, 1))[0]
            # Ten bins of 200 each, standard deviation 13.
            assert counts == pytest.approx(200, abs=65)


def test_uniform_sampler_without_limits_draws_over_one_turn() -> None:
    lower, upper = np.array([-np.inf, -1.0]), np.array([np.inf, 1.5])
    sampler = UniformSampler(lower, upper, np.random.default_rng(1))
    draws = np.array([sampler.draw() for _ in range(400)])
    assert (np.abs(draws[:, 0]) <= np.pi).all()
    counts = np.histogram(draws[:, 0], bins=4, range=(-np.pi, np.pi))[0]
    assert counts == pytest.approx(100, abs=20)


@pytest.mark.parametrize("seed", range(20))
def test_sixty_draws_leave_no_gap_that_a_camera_could_miss(seed: int) -> None:
    sampler = UniformSampler(LOWER, UPPER, np.random.default_rng(seed))
    draws = np.array([sampler.draw() for _ in range(60)])
    places = np.stack(np.meshgrid(*np.linspace(LOWER, UPPER, 40).T), -1).reshape(-1, 1, 2)
    seen = (np.abs(places - draws) < [0.36, 0.28]).all(axis=2).any(axis=1)
    assert seen.mean() > 0.97

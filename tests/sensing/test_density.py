"""Draws from internal models."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.density import DensitySampler
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import GaussianSample, KernelSample, Origin, Resource
from cbdsl.types.resource_type import POSITION

LOWER, UPPER = np.array([-1.0, -0.5]), np.array([1.0, 0.5])
SAMPLES = ((0.5, 0.2), (-0.6, -0.1), (-0.6, -0.1))
SOURCES = (
    GaussianSample("head", (0.1, -0.2), (0.05, 0.02)),
    GaussianSample("head", (0.9, 0.4), (0.5, 0.5)),
    KernelSample("head", SAMPLES, (0.05, 0.05)),
    KernelSample("head", SAMPLES, (0.05, 0.05), uniform=0.5),
)


def draws(source: GaussianSample | KernelSample, count: int = 400, seed: int = 0) -> np.ndarray:
    sampler = DensitySampler(source, LOWER, UPPER, np.random.default_rng(seed))
    return np.array([sampler.draw() for _ in range(count)])


@pytest.mark.parametrize("source", SOURCES)
def test_draws_keep_within_the_limits(source: GaussianSample | KernelSample) -> None:
    found = draws(source)
    assert (found >= LOWER).all() and (found <= UPPER).all()


def test_gaussian_has_its_mean_and_deviation() -> None:
    found = draws(SOURCES[0], 4000)
    assert found.mean(axis=0) == pytest.approx([0.1, -0.2], abs=0.005)
    assert found.std(axis=0) == pytest.approx([0.05, 0.02], rel=0.05)


def test_kernel_is_drawn_as_often_as_its_sample_occurs() -> None:
    found = draws(KernelSample("head", SAMPLES, (0.05, 0.05)), 3000)
    assert np.mean(found[:, 0] < 0) == pytest.approx(2 / 3, abs=0.03)


def test_density_outside_the_limits_gives_the_nearest_configuration() -> None:
    found = draws(GaussianSample("head", (5.0, 5.0), (0.01, 0.01)), 2)
    assert found == pytest.approx(np.tile(UPPER, (2, 1)))


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_share_of_the_draws_is_uniform(share: float) -> None:
    found = draws(GaussianSample("head", (0.9, 0.4), (0.01, 0.01), share), 4000)
    far = np.abs(found - (0.9, 0.4)).max(axis=1) > 0.06
    assert far.mean() == pytest.approx(share, abs=0.03)
    assert share == 0.0 or found[far].mean(axis=0) == pytest.approx([0, 0], abs=0.05)


def test_same_seed_gives_the_same_draws() -> None:
    assert draws(SOURCES[2], seed=4) == pytest.approx(draws(SOURCES[2], seed=4), abs=0)


def test_positions_have_no_limits(dexter: RobotDocument, kinematics: Kinematics) -> None:
    """Treat numbers beyond a joint's limits as a position like any other."""
    source = KernelSample("right_arm", ((9.0, -9.0, 0.5),), (0.1, 0.01, 0.001))
    places = Resource("right_arm.touched", POSITION, Origin.MODEL, source)
    sampler = Signals(dexter, kinematics, [places]).sampler(places, np.random.default_rng(0))
    found = np.array([sampler.draw() for _ in range(500)])
    assert found.mean(axis=0) == pytest.approx([9.0, -9.0, 0.5], abs=0.02)
    assert found.std(axis=0) == pytest.approx([0.1, 0.01, 0.001], rel=0.1)

"""Densities of one joint, and what they say of where rewards are expected."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.reproduction.internal_models import Expectation, marginal

KERNEL = Kernel(
    form="kernel", samples=((-0.5, 0.1), (0.8, 0.2)), bandwidth=(0.1, 0.05), uniform=0.25
)
GAUSSIAN = Gaussian(form="gaussian", mean=(0.2, 0.0), deviation=(0.15, 0.1), uniform=0.1)
ANGLES = np.linspace(-2.0, 2.0, 401)


@pytest.mark.parametrize("density", [KERNEL, GAUSSIAN], ids=["kernel", "gaussian"])
def test_a_density_adds_up_to_one(density: Kernel | Gaussian) -> None:
    row = marginal(density, 0, ANGLES)
    assert np.trapezoid(row, ANGLES) == pytest.approx(1, abs=1e-6)
    assert row.min() >= density.uniform / 4


def test_peaks_are_where_samples_are() -> None:
    row = marginal(KERNEL, 0, ANGLES)
    peaks = [
        angle
        for angle, before, here, after in zip(ANGLES[1:], row, row[1:], row[2:], strict=False)
        if before < here > after
    ]
    assert peaks == pytest.approx([-0.5, 0.8], abs=0.011)


def test_a_gaussian_has_its_deviation_apart_from_the_uniform_part() -> None:
    narrow = GAUSSIAN.model_copy(update={"uniform": 0.0})
    rows = np.array([marginal(narrow, 0, ANGLES), np.full(len(ANGLES), 0.25)])
    found = Expectation("joint", -2.0, 2.0, rows).deviations
    assert found == pytest.approx([0.15, 4 / np.sqrt(12)], rel=0.01)

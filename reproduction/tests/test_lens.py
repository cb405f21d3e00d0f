"""Lens and sensor: blur of the stated deviation, and noise of the stated deviation."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.chapter_3.lens import Lens


def _edge(times: int) -> np.ndarray:
    picture = np.zeros((20 * times, 60 * times, 3), dtype=np.uint8)
    picture[:, 30 * times :] = 240
    return picture


def _spread(image: np.ndarray) -> float:
    """Return the standard deviation of an edge's derivative, px."""
    weights = np.diff(image[5:15].astype(float).mean(axis=(0, 2)))
    at = np.arange(len(weights))
    mean = (weights @ at) / weights.sum()
    return float(np.sqrt(weights @ (at - mean) ** 2 / weights.sum()))


@pytest.mark.parametrize("spread", [0.8, 1.5])
@pytest.mark.parametrize("times", [4, 8])
def test_edge_is_blurred_by_the_spread_and_the_pixels_own_width(spread: float, times: int) -> None:
    image = Lens(spread, 0).photograph(_edge(times), times, 837, 1, np.random.default_rng(0))
    assert image.shape == (20, 60, 3)
    assert _spread(image) == pytest.approx(np.hypot(spread, np.sqrt(1 / 12)), rel=0.05)


def test_out_of_focus_a_point_becomes_the_disc_of_a_thin_lens() -> None:
    lens = Lens(0.0, 0, aperture=0.004, focus=0.5)
    assert lens.blur(837, 0.5) == 0
    # 837 px * 4 mm * (1/0.5 m - 1/1 m) = 3.348 px across
    assert lens.blur(837, 1.0) == pytest.approx(3.348 / 4)
    assert Lens(0.7, 0).blur(837, 0.1) == pytest.approx(0.7)


def test_noise_has_the_stated_deviation() -> None:
    grey = np.full((400, 400, 3), 128, dtype=np.uint8)
    image = Lens(0.8, 5.0).photograph(grey, 4, 837, 1, np.random.default_rng(0))
    assert image.std() == pytest.approx(5, rel=0.03)
    assert image.mean() == pytest.approx(128, abs=0.2)

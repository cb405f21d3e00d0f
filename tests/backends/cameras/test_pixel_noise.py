"""Noise of an image sensor."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from cbdsl.backends.cameras.rendered import PixelNoise

GREY = np.full((120, 160, 3), 100, np.uint8)


def test_noise_has_its_deviation_and_no_two_images_are_alike() -> None:
    noise = PixelNoise(3.0, np.random.default_rng(0))
    images = [noise.added(GREY).astype(float) for _ in range(5)]
    for image in images:
        assert image.std() == pytest.approx(3.0, rel=0.03)
        assert image.mean() == pytest.approx(100, abs=0.1)
    for before, after in itertools.pairwise(images):
        correlation = np.corrcoef((before - 100).ravel(), (after - 100).ravel())[0, 1]
        assert abs(correlation) < 0.03


def test_pixel_noise_saturates_and_does_not_modify_its_input() -> None:
    black = np.zeros((20, 20, 3), np.uint8)
    noisy = PixelNoise(5.0, np.random.default_rng(0)).added(black)
    assert noisy.max() < 40 and (noisy == 0).mean() > 0.4
    assert not black.any()


def test_without_noise_an_image_is_a_copy() -> None:
    same = PixelNoise(0.0, np.random.default_rng(0)).added(GREY)
    assert (same == GREY).all() and same is not GREY

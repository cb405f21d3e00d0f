"""Densities over two joint angles: their peaks, and their picture."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.chapter_4.posture_density import PostureDensity

LIMITS = {"pan": (-1.7, 1.7), "tilt": (-1.0, 1.5)}


def density(*postures: tuple[float, float]) -> PostureDensity:
    angles = np.array(postures, dtype=float).reshape(-1, 2)
    return PostureDensity("any", "<any>", angles, 0.1, LIMITS)


def test_postures_close_together_are_one_peak() -> None:
    ((pan, tilt),) = density((0.0, 0.4), (0.05, 0.42), (-0.05, 0.38)).peaks()
    assert (pan, tilt) == pytest.approx((0.0, 0.4), abs=0.03)


def test_postures_far_apart_are_peaks_of_their_own() -> None:
    assert len(density((0.0, 0.4), (1.3, 0.2)).peaks()) == 2
    # Peaks need at least a tenth of the highest one.
    assert len(density(*[(0.0, 0.4)] * 12, (1.3, 0.2)).peaks()) == 1


def test_posture_between_two_cells_is_one_peak() -> None:
    first, second = density((0.0, 0.0)).axes
    between = (float(first[40:42].mean()), float(second[20:22].mean()))
    assert len(density(between).peaks()) == 1


def test_density_without_postures_has_no_peak() -> None:
    assert density().peaks() == []
    assert "0 postures" in density().svg()


def test_picture_has_a_mark_for_each_posture() -> None:
    drawn = density((0.0, 0.4), (1.3, 0.2)).svg()
    assert drawn[drawn.index('id="postures"') :].count("<use") == 2
    assert "&lt;any&gt;" in drawn
    assert density((0.0, 0.4)).data()["postures"] == [[0.0, 0.4]]

"""Periods in images match the pinhole camera; localizability falls with nearness."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.chapter_3.table_3_2 import DEPTHS, localizability, measured_period, run
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict


def test_every_period_and_ratio_is_reproduced() -> None:
    outcome = run(RunSettings())
    assert len(outcome.quantities) == 13
    assert {each.verdict for each in outcome.quantities} == {Verdict.REPRODUCED}
    assert sum("misprint" in each.note for each in outcome.quantities) == 3


@pytest.mark.parametrize("period", [3.5, 8.0, 41.3])
def test_period_is_measured_from_dark_edges(period: float) -> None:
    at = np.arange(600)
    row = np.where((at % period) < period / 2, 0, 240).astype(np.uint8)
    picture = np.repeat(np.tile(row, (3, 1))[:, :, None], 3, axis=2)
    assert measured_period(picture) == pytest.approx(period, rel=0.01)


def test_pattern_without_two_stripes_has_no_period() -> None:
    assert np.isnan(measured_period(np.full((3, 50, 3), 240, dtype=np.uint8)))


@pytest.mark.parametrize("baseline", [0.12, 0.3, 0.35])
def test_localizability_equals_eq_3_6_for_planar_headings(baseline: float) -> None:
    for depth in DEPTHS:
        step = 1e-6

        def angles(x: float, y: float) -> np.ndarray:
            return np.arctan2([y - baseline / 2, y + baseline / 2], x)

        jacobian = np.stack(
            [
                (angles(depth + step, 0) - angles(depth - step, 0)) / (2 * step),
                (angles(depth, step) - angles(depth, -step)) / (2 * step),
            ],
            axis=1,
        )
        wanted = 1 / np.sqrt(np.linalg.det(jacobian.T @ jacobian))
        assert localizability(baseline, depth) == pytest.approx(wanted, rel=1e-6)

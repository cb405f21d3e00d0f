"""Printed law: it reaches singularities and admits the lower level; the project's does neither."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl_reproduction.chapter_3 import law_as_printed
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict

STEP = 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_jacobian_of_the_planar_arm_equals_finite_differences(seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, 3)
    jacobian, curvature = law_as_printed._planar(q)
    for joint, change in enumerate(STEP * np.eye(3)):
        slope = (tip(q + change) - tip(q - change)) / (2 * STEP)
        assert jacobian[:, joint] == pytest.approx(slope, abs=1e-8)
        ahead, behind = (law_as_printed._planar(q + way * change)[0] for way in (1, -1))
        assert curvature[:, :, joint] == pytest.approx((ahead - behind) / (2 * STEP), abs=1e-8)


def tip(q: np.ndarray) -> np.ndarray:
    """Return the position of the planar arm's tip, m, shape (2,)."""
    angles = np.cumsum(q)
    return law_as_printed._LINKS @ np.column_stack((np.cos(angles), np.sin(angles)))


def test_printed_law_is_missed_and_ours_is_reproduced() -> None:
    told: list[tuple[int, int]] = []
    settings = RunSettings(quick=True, progress=lambda done, total: told.append((done, total)))
    outcome = law_as_printed.run(settings)
    assert told == [(1, 2), (2, 2)]
    for quantity in outcome.quantities:
        ours = quantity.name.startswith("ours")
        assert (quantity.verdict is not Verdict.MISSED) == ours, quantity
        assert (quantity.ours == 100) == ours, quantity
    again = law_as_printed.run(RunSettings(quick=True))
    assert [each.ours for each in again.quantities] == [each.ours for each in outcome.quantities]
    assert again.charts == outcome.charts

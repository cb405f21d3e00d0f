"""A box is really taken in both hands and brought nearer."""

from __future__ import annotations

import pytest

from cbdsl.reproduction.experiment import RunSettings
from cbdsl.reproduction.fig_3_5 import run


@pytest.mark.slow
def test_a_box_is_held_and_comes_nearer() -> None:
    outcome = run(RunSettings(seed=50, quick=True))
    ours = {quantity.name: quantity.ours for quantity in outcome.quantities}
    assert ours["boxes held to the end"] == 100
    assert ours["depth, table"] > ours["depth, held"] > ours["depth, optimum"]
    assert ours["φ_l on the table by φ_l, optimum"] > ours["φ_l on the table by φ_l, held"] > 1
    (chart,) = outcome.charts
    assert chart.lines[0].y[-1] < chart.lines[0].y[0]

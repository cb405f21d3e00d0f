"""The barcode experiment runs through, and finer patterns are read less well from afar."""

from __future__ import annotations

import pytest

from cbdsl.reproduction.experiment import Settings
from cbdsl.reproduction.fig_3_6 import run


@pytest.mark.slow
def test_accuracy_falls_with_frequency_and_depth() -> None:
    steps: list[tuple[int, int]] = []
    outcome = run(Settings(quick=True, progress=lambda *step: steps.append(step)))
    share = {tuple(each.name.split(", ")[:2]): each.ours for each in outcome.quantities}
    assert steps == [(done, 9) for done in range(1, 10)]
    assert share["low", "table"] == share["low", "optimum"] == 1
    assert share["high", "table"] < share["high", "optimum"]
    for line in outcome.charts[1].lines:
        assert line.y[0] == 1
        assert line.y[-1] < 1

"""The barcode experiment runs through, and finer patterns are read less well from afar."""

from __future__ import annotations

import pytest

from cbdsl.reproduction.experiment import Settings
from cbdsl.reproduction.fig_3_6 import run


@pytest.mark.slow
def test_accuracy_falls_with_frequency_and_depth() -> None:
    steps: list[tuple[int, int]] = []
    outcome = run(Settings(quick=True, progress=lambda *step: steps.append(step)))
    sharp = outcome.quantities[: len(outcome.quantities) // 2]
    share = {tuple(each.name.split(", ")[:2]): each.ours for each in sharp}
    assert steps == [(done, 9) for done in range(1, 10)]
    assert share["low", "table"] == share["low", "optimum"] == 1
    assert share["high", "table"] < share["high", "optimum"]
    assert [line.name for line in outcome.charts[0].lines] == ["low", "medium", "high"]

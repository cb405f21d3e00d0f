"""The barcode experiment in full, with the box in the robot's own hands."""

from __future__ import annotations

import pytest

from cbdsl_reproduction.chapter_3.fig_3_6 import run
from cbdsl_reproduction.experiment import RunSettings


@pytest.mark.slow
def test_low_frequencies_are_read_from_everywhere_and_high_ones_not_from_afar() -> None:
    steps: list[tuple[int, int]] = []
    outcome = run(RunSettings(seed=4, quick=True, progress=lambda *step: steps.append(step)))
    sharp = outcome.quantities[: len(outcome.quantities) // 2]
    share = {tuple(each.name.split(", ")[:2]): each.ours for each in sharp}
    assert steps == [(1, 3), (2, 3), (3, 3)]
    assert share["low", "table"] == share["low", "held"] == share["low", "optimum"] == 100
    assert share["medium", "optimum"] == 100
    assert [line.name for line in outcome.charts[0].lines] == ["low", "medium", "high"]
    table, held, optimum = outcome.charts[0].lines[0].x
    assert table > held > optimum

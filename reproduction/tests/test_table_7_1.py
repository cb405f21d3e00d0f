"""Shares of stacks that stand, from kept trials."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cbdsl_reproduction.chapter_7.table_7_1 import STACKS, run
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.kept_trials import KeptTrials
from cbdsl_reproduction.quantity import Quantity, Verdict
from cbdsl_reproduction.stack_trials import StackTrial, stack_digest

FLAT = "purple_box_on_blue_box"


def keep(folder: Path, flat: int, *, others: bool) -> RunSettings:
    """Keep trials: flat on flat stands in ``flat`` of 80, and all others always or never."""
    for name in STACKS:
        kept = KeptTrials(folder / "mujoco_ideal.jsonl", stack_digest(name), StackTrial)
        for seed in range(80 if name == FLAT else 40):
            stands = seed < flat if name == FLAT else others
            kept.add(StackTrial(name, seed, True, stands, 0.0, 0.02, 2.0, ""))
    return RunSettings(folder=folder, backend="mujoco", cameras="ideal")


def of_flat(folder: Path, flat: int) -> Quantity:
    result = run(keep(folder, flat, others=False))
    return next(each for each in result.quantities if each.name == FLAT.replace("_", " "))


@pytest.mark.parametrize(
    ("flat", "verdict"),
    [
        (80, Verdict.REPRODUCED),
        (68, Verdict.REPRODUCED),
        (45, Verdict.UNDECIDED),
        (8, Verdict.MISSED),
    ],
)
def test_share_of_a_stack_is_judged_by_the_trials_of_the_source(
    tmp_path: Path, flat: int, verdict: Verdict
) -> None:
    judged = of_flat(tmp_path, flat)
    assert judged.note.startswith(f"{flat} of 80;")
    assert judged.verdict is verdict


def test_stacks_that_always_stand_miss_a_low_share_of_the_source(tmp_path: Path) -> None:
    result = run(keep(tmp_path, 80, others=True))
    missed = {each.claim.report for each in result.quantities if each.verdict is Verdict.MISSED}
    assert missed == {"0 %", "20 %", "40 %"}


def test_every_stack_has_its_own_share(tmp_path: Path) -> None:
    result = run(keep(tmp_path, 0, others=True))
    assert [each.ours for each in result.quantities] == [0.0] + [100.0] * (len(STACKS) - 1)
    assert all(each.note.endswith("let go; pace 20 mm/s") for each in result.quantities)
    assert not any(math.isnan(each.ours) for each in result.quantities)

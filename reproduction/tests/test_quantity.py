"""Verdicts, which follow from intervals and from the rate at which chance would pass."""

from __future__ import annotations

import math

import pytest

from cbdsl_reproduction.claim import Interval, above
from cbdsl_reproduction.quantity import Quantity, Verdict, computed


@pytest.mark.parametrize(
    ("ours", "interval", "verdict"),
    [
        (0.9, (0.85, 0.95), Verdict.REPRODUCED),
        (0.9, (0.75, 0.95), Verdict.ORDERING),
        (0.9, (0.45, 0.95), Verdict.UNDECIDED),
        (0.3, (0.1, 0.45), Verdict.MISSED),
        (0.9, None, Verdict.NOT_JUDGED),
        (math.nan, None, Verdict.MISSED),
    ],
)
def test_the_whole_interval_decides(
    ours: float, interval: Interval | None, verdict: Verdict
) -> None:
    quantity = Quantity("share", "", "most", ours, above(0.8), above(0.5), interval)
    assert quantity.verdict is verdict


def test_quantity_with_a_large_chance_is_undecided() -> None:
    few = Quantity("share", "", "most", 0.9, above(0.8), interval=(0.85, 0.95), chance=0.06)
    assert few.verdict is Verdict.UNDECIDED


def test_quantity_without_a_claim_is_not_judged() -> None:
    assert Quantity("level", "", "drawn", 0.9, None, interval=(0.8, 1)).verdict is (
        Verdict.NOT_JUDGED
    )


def test_computed_numbers_have_no_spread() -> None:
    assert computed("ratio", "", "2", 2.0, above(1)).verdict is Verdict.REPRODUCED
    assert computed("ratio", "", "2", 0.5, above(1)).verdict is Verdict.MISSED
    assert computed("ratio", "", "2", math.nan, above(1)).verdict is Verdict.MISSED

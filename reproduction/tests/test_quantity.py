"""Verdicts, which follow from intervals and from the rate at which chance would pass."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.quantity import Quantity, Verdict, computed
from cbdsl_reproduction.region import Interval, above

MOST = Claim("", "share", "", "most", above(0.8), above(0.5))


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
def test_whole_interval_decides(ours: float, interval: Interval | None, verdict: Verdict) -> None:
    quantity = Quantity(MOST, ours, interval)
    assert quantity.verdict is verdict


def test_quantity_with_a_large_chance_is_undecided() -> None:
    few = Quantity(replace(MOST, ordering=None), 0.9, (0.85, 0.95), chance=0.06)
    assert few.verdict is Verdict.UNDECIDED


def test_quantity_without_a_claim_is_not_judged() -> None:
    drawn = Quantity(Claim("", "level", "", "drawn"), 0.9, (0.8, 1))
    assert drawn.verdict is Verdict.NOT_JUDGED


def test_computed_numbers_have_no_spread() -> None:
    ratio = Claim("", "ratio", "", "2", above(1))
    assert computed(ratio, 2.0).verdict is Verdict.REPRODUCED
    assert computed(ratio, 0.5).verdict is Verdict.MISSED
    assert computed(ratio, math.nan).verdict is Verdict.MISSED

"""Verdicts follow from rules."""

from __future__ import annotations

import math

import pytest

from cbdsl.reproduction.quantity import (
    Claim,
    Quantity,
    Verdict,
    above,
    at_least,
    at_most,
    below,
    clearly_above,
    clearly_below,
    covering,
    near,
)


@pytest.mark.parametrize(
    ("claim", "holds", "fails"),
    [
        (above(1.0), 1.1, 1.0),
        (below(1.0), 0.9, 1.0),
        (at_least(1.0), 1.0, 0.9),
        (at_most(1.0), 1.0, 1.1),
        (near(1.0, 0.1), 1.1, 1.11),
    ],
    ids=lambda value: value.text if isinstance(value, Claim) else str(value),
)
def test_claims_about_numbers(claim: Claim, holds: float, fails: float) -> None:
    assert claim.holds(holds, None)
    assert not claim.holds(fails, None)


def test_claims_about_intervals() -> None:
    assert clearly_above(0.5).holds(0.7, (0.6, 0.8))
    assert not clearly_above(0.5).holds(0.7, (0.4, 0.8))
    assert not clearly_above(0.5).holds(0.7, None)
    assert covering(0.5).holds(0.3, (0.2, 0.6))
    assert not covering(0.5).holds(0.3, (0.2, 0.4))
    assert not covering(0.5).holds(0.5, None)
    assert clearly_below(0.5).holds(0.3, (0.2, 0.4))
    assert not clearly_below(0.5).holds(0.3, (0.2, 0.6))
    assert not clearly_below(0.5).holds(0.3, None)


@pytest.mark.parametrize(
    ("ours", "verdict"),
    [
        (0.9, Verdict.REPRODUCED),
        (0.7, Verdict.ORDERING),
        (0.3, Verdict.MISSED),
        (math.nan, Verdict.MISSED),
    ],
)
def test_the_verdict_is_the_strongest_rule_that_holds(ours: float, verdict: Verdict) -> None:
    quantity = Quantity("share", "", "more than 0.8", ours, above(0.8), ordering=above(0.5))
    assert quantity.verdict is verdict

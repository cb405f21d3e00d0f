"""Claims as regions: an interval lies inside, outside or across the boundary."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_reproduction.claim import (
    Claim,
    Interval,
    above,
    at_least,
    at_most,
    below,
    between,
    in_hindsight,
    near,
)

# Each claim with an interval in it, one across its end, and one out of it.
CASES: list[tuple[Claim, Interval, Interval, Interval]] = [
    (above(1.0), (1.1, 2.0), (1.0, 2.0), (0.5, 1.0)),
    (below(1.0), (0.5, 0.9), (0.5, 1.0), (1.0, 2.0)),
    (at_least(1.0), (1.0, 2.0), (0.9, 2.0), (0.5, 0.9)),
    (at_most(1.0), (0.5, 1.0), (0.5, 1.1), (1.1, 2.0)),
    (near(1.0, 0.1), (0.9, 1.1), (0.95, 1.2), (1.2, 1.3)),
    (between(0.0, 1.0), (0.0, 1.0), (-0.1, 0.5), (-1.0, -0.1)),
]
NAMES = [claim.text for claim, *_ in CASES]


@pytest.mark.parametrize(("claim", "inside", "across", "outside"), CASES, ids=NAMES)
def test_an_interval_is_in_a_region_or_out_of_it_or_neither(
    claim: Claim, inside: Interval, across: Interval, outside: Interval
) -> None:
    assert claim.contains(inside) and not claim.excludes(inside)
    assert not claim.contains(across) and not claim.excludes(across)
    assert claim.excludes(outside) and not claim.contains(outside)


@pytest.mark.parametrize("claim", [case[0] for case in CASES], ids=NAMES)
@given(ends=st.tuples(st.floats(-5, 5), st.floats(-5, 5)))
def test_no_interval_satisfies_a_claim_and_its_negation(
    claim: Claim, ends: tuple[float, float]
) -> None:
    low, high = sorted(ends)
    if high - low > 1e-6:
        assert not (claim.contains((low, high)) and claim.excludes((low, high)))


def test_claims_made_in_hindsight_say_so() -> None:
    late = in_hindsight(at_least(95))
    assert late.hindsight and "hindsight" in late.text
    assert late.contains((95, 100)) and not late.contains((94, 100))

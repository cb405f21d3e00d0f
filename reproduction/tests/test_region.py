"""Regions: an interval lies inside, outside or across the boundary."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl_reproduction.region import (
    Interval,
    ValueRegion,
    above,
    at_least,
    at_most,
    below,
    between,
    in_hindsight,
    near,
)

# Each region with an interval in it, one across its end, and one out of it.
CASES: list[tuple[ValueRegion, Interval, Interval, Interval]] = [
    (above(1.0), (1.1, 2.0), (1.0, 2.0), (0.5, 1.0)),
    (below(1.0), (0.5, 0.9), (0.5, 1.0), (1.0, 2.0)),
    (at_least(1.0), (1.0, 2.0), (0.9, 2.0), (0.5, 0.9)),
    (at_most(1.0), (0.5, 1.0), (0.5, 1.1), (1.1, 2.0)),
    (near(1.0, 0.1), (0.9, 1.1), (0.95, 1.2), (1.2, 1.3)),
    (between(0.0, 1.0), (0.0, 1.0), (-0.1, 0.5), (-1.0, -0.1)),
]
NAMES = [region.text for region, *_ in CASES]


@pytest.mark.parametrize(("region", "inside", "across", "outside"), CASES, ids=NAMES)
def test_interval_is_in_a_region_or_out_of_it_or_neither(
    region: ValueRegion, inside: Interval, across: Interval, outside: Interval
) -> None:
    assert region.contains(inside) and not region.excludes(inside)
    assert not region.contains(across) and not region.excludes(across)
    assert region.excludes(outside) and not region.contains(outside)


@pytest.mark.parametrize("region", [case[0] for case in CASES], ids=NAMES)
@given(ends=st.tuples(st.floats(-5, 5), st.floats(-5, 5)))
def test_no_interval_satisfies_a_region_and_its_negation(
    region: ValueRegion, ends: tuple[float, float]
) -> None:
    low, high = sorted(ends)
    if high - low > 1e-6:
        assert not (region.contains((low, high)) and region.excludes((low, high)))


def test_region_set_in_hindsight_says_so() -> None:
    late = in_hindsight(at_least(95))
    assert late.hindsight and "hindsight" in late.text
    assert late.contains((95, 100)) and not late.contains((94, 100))

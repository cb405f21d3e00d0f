"""Conditions that types and constants leave only one value."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.program.condition import Component, ProgramCondition, SumComparison
from cbdsl.types.resource import Opening, Origin, Resource
from cbdsl.types.resource_type import LENGTH, OFFSET

WIDTH = Component(Resource("width", LENGTH, Opening("hand"), Origin.ENVIRONMENT), 0)
PLACE = Component(Resource("place", OFFSET, Opening("hand"), Origin.ENVIRONMENT), 2)


def above(component: Component, bound: float, factor: float = 1.0) -> SumComparison:
    return SumComparison({component: factor}, -factor * bound, is_strict=True)


def condition(*parts: SumComparison | str) -> ProgramCondition:
    return ProgramCondition("it", "", parts, 0.0)


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ([above(WIDTH, 0.1)], None),
        ([above(WIDTH, -0.1)], True),
        ([above(WIDTH, -0.1, -1.0)], False),
        ([above(PLACE, -0.1)], None),
        ([above(PLACE, 0.3), above(PLACE, 0.2, -1.0), "and"], False),
        ([above(PLACE, 0.2), above(PLACE, 0.3, -2.0), "or"], True),
        ([above(PLACE, 0.3), above(WIDTH, 0.2, -1.0), "and"], None),
        ([above(WIDTH, 0.3), above(WIDTH, 0.3), "not", "or"], True),
        ([SumComparison({WIDTH: 0.0}, 0.0, is_strict=True)], False),
        ([SumComparison({WIDTH: 0.0}, 0.0, is_strict=False)], True),
    ],
)
def test_constant_returns_the_only_value_of_a_condition(
    parts: list[SumComparison | str], expected: bool | None
) -> None:
    assert condition(*parts).constant() is expected


BOUNDS = st.sampled_from([-0.2, -0.1, 0.0, 0.1, 0.2])
COMPARISONS = st.builds(
    above, st.sampled_from([WIDTH, PLACE]), BOUNDS, st.sampled_from([-2.0, -1.0, 1.0, 3.0])
)


@given(st.lists(st.tuples(COMPARISONS, st.sampled_from(["and", "or"])), min_size=1, max_size=4))
def test_constant_agrees_with_a_scan_of_a_grid_of_values(
    pairs: list[tuple[SumComparison, str]],
) -> None:
    parts = [pairs[0][0], *(part for pair in pairs[1:] for part in pair)]
    steps = [0.01 * i for i in range(-30, 31)]
    values = set()
    for width, place in itertools.product([step for step in steps if step >= 0.0], steps):
        value = {WIDTH: width, PLACE: place}
        truth = [
            sum(f * value[c] for c, f in each.factors.items()) + each.constant > 0.0
            for each, _ in pairs
        ]
        result = truth[0]
        for own, (_, operator) in zip(truth[1:], pairs[1:], strict=True):
            result = (result and own) if operator == "and" else (result or own)
        values.add(result)
    assert condition(*parts).constant() is (values.pop() if len(values) == 1 else None)

"""Conditions in the compiled tick: three values, and the time for which they hold."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.conditions.condition_plan import ConditionPlan, note_conditions
from cbdsl.program.condition import Component, ProgramCondition, SumComparison
from cbdsl.sensing.signal_arrays import TableArrays
from cbdsl.sensing.table.refresh import DEFINED, ROW, UNDEFINED
from cbdsl.types.resource import Opening, Origin, Resource
from cbdsl.types.resource_type import LENGTH

RESOURCES = [Resource(name, LENGTH, Opening(name), Origin.ENVIRONMENT) for name in "abc"]
ROWS = {resource: place for place, resource in enumerate(RESOURCES)}


def table(values: list[float | None]) -> TableArrays:
    """Return a table with one number per row; ``None`` is undefined."""
    records = np.zeros(len(values), ROW)
    records["start"], records["size"] = np.arange(len(values)), 1
    records["defined"] = [UNDEFINED if value is None else DEFINED for value in values]
    numbers = np.array([0.0 if value is None else value for value in values])
    parts: Any = SimpleNamespace(records=records, value=numbers)
    return TableArrays(
        parts.records, np.zeros(0, ROW), np.zeros(0, np.int64), parts.value, np.zeros((1, 1))
    )


def note(plan: ConditionPlan, values: list[float | None]) -> str:
    note_conditions(
        np.array(plan.watched), plan.conditions, plan.operations, plan.terms, table(values)
    )
    return "".join(plan.letter(number) for number in plan.watched)


def above(place: int, bound: float, *, is_strict: bool = True) -> SumComparison:
    return SumComparison({Component(RESOURCES[place], 0): 1.0}, -bound, is_strict)


@st.composite
def trees(draw: st.DrawFn, depth: int = 3) -> Any:
    """Nested tuples of operators and places of signals that have to be above 0."""
    kind = draw(st.sampled_from(["at", "not", "and", "or"] if depth else ["at"]))
    if kind == "at":
        return draw(st.integers(0, 2))
    if kind == "not":
        return "not", draw(trees(depth - 1))
    return kind, draw(trees(depth - 1)), draw(trees(depth - 1))


def postfix(tree: Any) -> list[SumComparison | str]:
    if isinstance(tree, int):
        return [above(tree, 0.0)]
    return [*(part for each in tree[1:] for part in postfix(each)), tree[0]]


def kleene(tree: Any, values: list[float | None]) -> float:
    """Return 0 for false, 1/2 for undefined and 1 for true: minimum, maximum and complement."""
    if isinstance(tree, int):
        value = values[tree]
        return 0.5 if value is None else float(value > 0.0)
    parts = [kleene(each, values) for each in tree[1:]]
    return 1.0 - parts[0] if tree[0] == "not" else (min if tree[0] == "and" else max)(parts)


@given(trees(), st.lists(st.sampled_from([None, -1.0, 1.0]), min_size=3, max_size=3))
def test_conditions_have_the_values_of_kleenes_logic(tree: Any, values: list[float | None]) -> None:
    plan = ConditionPlan()
    plan.add(ProgramCondition("it", "", tuple(postfix(tree)), 0.0), ROWS, 0.01)
    plan.watch((0,))
    assert note(plan, values) == {0.0: "0", 0.5: "-", 1.0: "1"}[kleene(tree, values)]


def test_condition_with_a_time_is_true_once_it_has_held_for_that_time() -> None:
    plan = ConditionPlan()
    plan.add(ProgramCondition("it", "", (above(0, 1.0),), 0.03), ROWS, 0.01)
    assert plan.letter(0) == "-"
    plan.watch((0,))
    course = [2.0, 2.0, 0.0, 2.0, 2.0, 2.0, 2.0, None, 2.0, 2.0, 2.0, 1.0]
    assert [note(plan, [value, None, None]) for value in course] == list("0000011-0010")
    note(plan, [2.0, None, None])
    plan.watch((), (0,))
    plan.watch((0,))
    assert plan.letter(0) == "-"
    assert note(plan, [2.0, None, None]) == "0"


def test_comparison_at_its_bound_is_true_if_it_is_not_strict() -> None:
    plan = ConditionPlan()
    plan.add(ProgramCondition("one", "", (above(0, 1.0),), 0.0), ROWS, 0.01)
    plan.add(ProgramCondition("two", "", (above(0, 1.0, is_strict=False),), 0.0), ROWS, 0.01)
    plan.watch((0, 1))
    assert note(plan, [1.0, None, None]) == "01"


def test_watch_keeps_conditions_that_both_steps_name() -> None:
    plan = ConditionPlan()
    for name in "ab":
        plan.add(ProgramCondition(name, "", (above(0, 1.0),), 0.02), ROWS, 0.01)
    plan.watch((0,))
    note(plan, [2.0, None, None])
    plan.watch((0, 1), (0,))
    assert note(plan, [2.0, None, None]) == "10"
    watched = plan.watched
    plan.watch((0, 1), (0, 1))
    assert plan.watched is watched

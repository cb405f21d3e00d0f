"""Levels, tick by tick: the active levels, their age, and their ticks in the law."""

from __future__ import annotations

import numpy as np

from cbdsl.control.level import Level
from cbdsl.control.stack import TICKS, Stack


def level(name: str, number: float, rows: int) -> Level:
    return Level(name, np.full((rows, 3), number), np.full(rows, -number))


def test_stack_returns_only_acting_levels() -> None:
    stack = Stack([("high", 2), ("low", 1)], 3)
    assert stack.extrapolated() == ()
    stack.put(1, level("low", 4.0, 1))
    (seen,) = stack.extrapolated()
    assert seen.name == "low"
    np.testing.assert_array_equal(seen.jacobian, np.full((1, 3), 4.0))
    np.testing.assert_array_equal(seen.velocity, [-4.0])


def test_returning_level_has_no_past() -> None:
    """Levels that come back have no past, even if their neighbours have one."""
    stack = Stack([("high", 2), ("low", 1)], 3)
    for tick in range(5):
        # The next of three ticks, as ``tick`` begins it.
        stack.clock[0] = (stack.newest + 1) % TICKS
        stack.put(0, level("high", float(tick), 2))
        if tick == 3:
            stack.ages[1] = 0
        else:
            stack.put(1, level("low", float(tick * tick), 1))
    assert stack.ages.tolist() == [3, 1]
    high, low = stack.extrapolated()
    np.testing.assert_allclose(high.jacobian, 4.5)  # along the line, half a tick ahead
    np.testing.assert_allclose(low.jacobian, 16.0)  # as it is
    stack.forget()
    assert stack.extrapolated() == ()


def test_values_are_split_by_the_levels_that_act() -> None:
    stack = Stack([("high", 2), ("middle", 1), ("low", 3)], 3)
    stack.put(0, level("high", 1.0, 2))
    stack.put(2, level("low", 1.0, 3))
    parts = stack.split(np.arange(6.0))
    assert [part.tolist() for part in parts] == [[0.0, 1.0], [3.0, 4.0, 5.0]]

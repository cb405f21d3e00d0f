"""Bounds of rows: no level passes one above it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.control.stack import TICKS, Stack
from cbdsl.numeric.arrays import Floats
from tests.control.chain import Chain

JOINTS = 7
seeds = st.integers(0, 2**32 - 1)


def law_of(step: float = 1e3) -> Law:
    limits = np.full(JOINTS, 1e3)
    return Law(-limits, limits, LawSettings(joint_step=step, damping=0.0))


def bounded(levels: list[Level], sides: Floats) -> Stack:
    stack = Stack.of(levels, JOINTS)
    stack.arrays.sides[:] = sides
    return stack


def random_levels(rng: np.random.Generator) -> tuple[list[Level], Floats]:
    """Return two to five levels, and the sides of their rows; allowed ways are not negative."""
    levels, sides = [], []
    for number in range(rng.integers(2, 6)):
        rows = rng.normal(size=(rng.integers(1, 4), JOINTS))
        if levels and rng.random() < 0.3:
            rows = rng.normal(size=(len(rows), len(levels[-1].jacobian))) @ levels[-1].jacobian
        side = rng.choice([-1.0, 1.0], len(rows)) * (rng.random() < 0.5)
        asked = rng.normal(size=len(rows))
        levels.append(Level(str(number), rows, np.where(side != 0.0, side * abs(asked), asked)))
        sides.append(side)
    return levels, np.concatenate(sides)


@given(seed=seeds)
def test_level_never_passes_a_bound_above_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    levels, sides = random_levels(rng)
    step, before = 10.0 ** rng.uniform(-2, 1), np.zeros(0)
    for count in range(1, len(levels) + 1):
        own, rows = levels[:count], sum(len(level.velocity) for level in levels[:count])
        stack = bounded(own, sides[:rows])
        displacement = law_of(step).compose(stack, np.zeros(JOINTS)).displacement
        past = np.concatenate([each.jacobian @ displacement - each.velocity for each in own])
        past *= sides[:rows]
        assert (past[: len(before)][before <= 1e-9] <= 1e-9).all()
        before = past


@given(seed=seeds)
def test_level_below_bounds_of_its_axes_moves_up_to_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, wanted = rng.normal(size=(3, JOINTS)), rng.normal(size=3)
    side, room = rng.choice([-1.0, 0.0, 1.0], 3), rng.uniform(0.0, 1.0, 3)
    bounds = [
        Level(str(i), rows[i : i + 1], side[i : i + 1] * room[i]) for i in range(3) if side[i]
    ]
    stack = bounded([*bounds, Level("task", rows, wanted)], np.append(side[side != 0], np.zeros(3)))
    moved = rows @ law_of().compose(stack, np.zeros(JOINTS)).displacement
    expected = np.where(side == 0, wanted, side * np.minimum(side * wanted, room))
    np.testing.assert_allclose(moved, expected, atol=1e-8)


def test_bound_that_no_level_reaches_changes_nothing(rng: np.random.Generator) -> None:
    for _ in range(50):
        task = [Level(str(i), rng.normal(size=(2, JOINTS)), rng.normal(size=2)) for i in range(2)]
        far = Level("bound", rng.normal(size=(2, JOINTS)), np.array([100.0, -100.0]))
        free = law_of().solve(task, np.zeros(JOINTS)).displacement.copy()
        stack = bounded([far, *task], np.array([1.0, -1.0, 0, 0, 0, 0]))
        step = law_of().compose(stack, np.zeros(JOINTS))
        np.testing.assert_array_equal(step.displacement, free)
        assert not step.levels[0].jacobian.any() and step.reports[0].share == 1.0


def test_bound_that_a_level_reaches_reports_its_row() -> None:
    bound, task = (
        Level("bound", np.eye(JOINTS)[:1], np.array([0.1])),
        Level("task", np.eye(JOINTS)[:2], np.array([1.0, 1.0])),
    )
    step = law_of().compose(bounded([bound, task], np.array([1.0, 0, 0])), np.zeros(JOINTS))
    np.testing.assert_allclose(step.displacement[:2], [0.1, 1.0])
    assert step.levels[0].jacobian[0, 0] == 1.0 and step.reports[1].rank == 1


@pytest.mark.parametrize("seed", range(8))
def test_targets_that_jump_never_bring_a_tip_past_a_bound(seed: int) -> None:
    """Follow a chain whose lower level asks for a random speed of up to 1 m/s in each tick."""
    rng = np.random.default_rng(seed)
    chain, tick = Chain.random(JOINTS, rng), 1 / 60
    q = rng.uniform(-1, 1, JOINTS)
    floor = chain.pose(q)[0][2] - 0.05
    stack = Stack([("bound", 1), ("task", 3)], JOINTS)
    stack.arrays.sides[0] = -1.0
    law, least = law_of(3.0 * tick), np.inf
    velocity = np.zeros(3)
    for now in range(600):
        if now % 15 == 0:
            velocity = rng.uniform(-1, 1, 3)
        place, _, jacobian = chain.pose(q)
        room = place[2] - floor
        stack.clock[0] = (stack.newest + 1) % TICKS
        stack.put(0, Level("bound", jacobian[2:3], np.array([-room if room > 0 else -0.5 * room])))
        stack.put(1, Level("task", jacobian[:3], velocity * tick))
        q = q + law.compose(stack, q).displacement
        least = min(least, chain.pose(q)[0][2] - floor)
    assert least > -1e-3

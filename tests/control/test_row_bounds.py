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


def law_of(step: float = 1e3, damping: float = 0.0) -> Law:
    limits = np.full(JOINTS, 1e3)
    return Law(-limits, limits, LawSettings(joint_step=step, damping=damping))


def bounded(levels: list[Level], sides: Floats) -> Stack:
    stack = Stack.of(levels, JOINTS)
    stack.arrays.sides[:] = sides
    stack.arrays.errors[:] = 0.0  # nothing beyond the requests
    return stack


def curved(levels: list[Level], rng: np.random.Generator) -> list[Level]:
    """Return levels with random Hessians."""
    bends = [rng.normal(size=(len(each.velocity), JOINTS, JOINTS)) for each in levels]
    return [
        level._replace(hessian=bend + bend.transpose(0, 2, 1), fraction=0.5)
        for level, bend in zip(levels, bends, strict=True)
    ]


def random_levels(rng: np.random.Generator) -> tuple[list[Level], Floats]:
    """Return two to five levels, and the sides of their rows; allowed ways are not negative."""
    levels: list[Level] = []
    sides = []
    for number in range(rng.integers(2, 6)):
        rows = rng.normal(size=(rng.integers(1, 4), JOINTS))
        if levels and rng.random() < 0.3:
            rows = rng.normal(size=(len(rows), len(levels[-1].jacobian))) @ levels[-1].jacobian
        side = rng.choice([-1.0, 1.0], len(rows)) * (
            rng.random(len(rows)) < rng.choice([0, 0.5, 1])
        )
        asked = rng.normal(size=len(rows))
        levels.append(Level(str(number), rows, np.where(side != 0.0, side * abs(asked), asked)))
        sides.append(side)
    return curved(levels, rng) if rng.random() < 0.5 else levels, np.concatenate(sides)


@given(seed=seeds)
def test_hessians_of_levels_that_move_as_requested_change_nothing(seed: int) -> None:
    """Idle rows of a level, and its own rows that it reaches, are no singularity."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 4, 2)
    levels = [Level(str(n), rng.normal(size=(n, JOINTS)), rng.normal(size=n)) for n in counts]
    sides = rng.choice([-1.0, 0.0, 1.0], sum(counts))
    for level, side in zip(levels, np.split(sides, counts[:1]), strict=True):
        level.velocity[:] *= np.where(side * level.velocity < 0.0, -1.0, 1.0)
    flat, bent = (
        law_of().compose(bounded(each, sides), np.zeros(JOINTS)).displacement
        for each in (levels, curved(levels, rng))
    )
    np.testing.assert_allclose(bent, flat, rtol=1e-6, atol=1e-8)
    asked, rows = (np.concatenate([each[key] for each in levels]) for key in (2, 1))
    np.testing.assert_allclose((rows @ bent - asked)[sides == 0.0], 0.0, atol=1e-6)


@given(seed=seeds)
def test_bounds_of_a_level_act_as_those_of_a_level_above_it(seed: int) -> None:
    """Also if the level is singular, and bends by its Hessians."""
    rng = np.random.default_rng(seed)
    count, rank = rng.integers(1, 4, 2)
    rows = rng.normal(size=(count, rank)) @ rng.normal(size=(rank, JOINTS))
    sides = rng.choice([-1.0, 1.0], rng.integers(1, 3))
    allowed = 0.02 * sides * rng.random(len(sides))
    levels = [
        Level("bound", rng.normal(size=(len(sides), JOINTS)), allowed),
        Level("task", rows, 0.1 * rng.normal(size=count)),
        Level("rest", np.eye(JOINTS)[:4], rng.normal(size=4)),
    ]
    levels = curved(levels, rng) if rng.random() < 0.8 else levels
    bends = [level.hessian for level in levels[:2] if level.hessian is not None]
    bound, task, rest = levels
    one = Level(
        "both",
        np.concatenate((bound.jacobian, task.jacobian)),
        np.concatenate((bound.velocity, task.velocity)),
        np.concatenate(bends) if bends else None,
        task.fraction,
    )
    law, sides = law_of(damping=0.01), np.append(sides, np.zeros(count + 4))
    above, within = (
        law.compose(bounded(each, sides), np.zeros(JOINTS)).displacement
        for each in (levels, [one, rest])
    )
    np.testing.assert_allclose(within, above, rtol=1e-6, atol=1e-9)


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


@pytest.mark.parametrize("size", [1.0, 0.1])
def test_level_that_reaches_its_own_bound_needs_no_hessians(size: float) -> None:
    rows, asked = size * np.array([[1.0, 0.0], [-1.0, 1.0]]), size * np.array([-0.4, 0.1])
    stack = Stack.of([Level("task", rows, asked, np.ones((2, 2, 2)), 0.5)], 2)
    stack.arrays.sides[1] = 1.0
    bound = np.full(2, 1e3)
    step = Law(-bound, bound, LawSettings(joint_step=1e3)).compose(stack, np.zeros(2))
    np.testing.assert_allclose(step.displacement, [-0.4, -0.3])
    assert not stack.arrays.bent


def test_idle_bound_leaves_the_step_from_a_saddle_as_long() -> None:
    """The step is as long as the rows that act need for the request."""
    bends, limit, moved = np.zeros((3, 3, 3)), np.full(3, 1e3), []
    bends[1, 1, 1] = 1.0
    rows, asked = np.diag([0.5, 0.0, 1.0]), np.array([0.0, 0.01, 9.0])
    task = Level("task", rows, asked, bends, 0.5)
    alone = Level("task", rows[:2], asked[:2], bends[:2], 0.5)
    above = Level("above", np.eye(3)[:1], np.zeros(1))
    law = Law(-limit, limit, LawSettings(joint_step=1e3))
    for level in (alone, task):
        stack = Stack.of([above, level], 3)
        stack.arrays.sides[3:], stack.arrays.errors[:] = 1.0, 0.02
        moved.append(law.compose(stack, np.zeros(3)).displacement.copy())
    assert moved[0][1] != 0.0
    np.testing.assert_allclose(moved[1], moved[0])


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

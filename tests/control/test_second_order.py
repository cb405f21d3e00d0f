"""Second order of the law: stacks come to rest at every target, and no level spoils those above."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from cbdsl.control.basis import Basis, empty_basis, pin_joints, resist, span
from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.control.second_order import (
    Way,
    add_curvature,
    balance,
    least_resisted,
    newton_step,
)
from cbdsl.control.stack import TICKS, Stack
from cbdsl.kinematics.rotation import exp, log
from cbdsl.numeric.arrays import Floats
from tests.control.chain import Chain

PERIOD = 1 / 60  # s
STILL = np.radians(0.02)  # a tick
STACKS = ("p", "pr", "prq", "pq", "rp", "rpq", "zpq", "pzrq")


class Stretched(NamedTuple):
    """An arm, a target of its tip, and the controllers that act, highest priority first.

    Their letters are those of the tip's position, rotation and height, and of the joints. The gain
    is 8 /s, with ticks of ``period`` seconds.
    """

    chain: Chain
    start: Floats
    position: Floats
    rotation: Floats
    stack: str
    limit: float
    period: float = PERIOD

    @property
    def fraction(self) -> float:
        return 8.0 * self.period / 2

    def law(self) -> Law:
        bound = np.full(self.chain.joints, self.limit)
        return Law(-bound, bound, LawSettings(joint_step=1.5 * self.period))


def stretched(seed: int) -> Stretched:
    """Sample a planar or spatial arm of 3 to 9 joints; half of the targets are out of reach."""
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(3, 10))
    length = rng.uniform(0.6, 1.3)
    if rng.random() < 0.5:
        chain = Chain.planar(joints, length)
    else:
        chain = Chain.random(joints, rng)
        chain = Chain(chain.axes, chain.links * length / np.linalg.norm(chain.links, axis=1).sum())
    goal = rng.uniform(-1.5, 1.5, joints)
    position, rotation, _ = chain.pose(goal)
    if seed % 2:
        way = rng.normal(size=3) * (1.0, 1.0, float(np.ptp(chain.axes[:, 2]) > 0.0))
        position = length * rng.uniform(1.0, 1.5) * way / np.linalg.norm(way)
    limit = 10.0 if rng.random() < 0.5 else 2.0
    start = rng.uniform(-0.6, 0.6, joints)
    return Stretched(chain, start, position, rotation, str(rng.choice(STACKS)), limit)


def capped(vector: Floats, largest: float) -> Floats:
    return vector * min(1.0, largest / max(float(np.linalg.norm(vector)), 1e-12))


def levels(case: Stretched, q: Floats, *, bent: bool = True) -> list[Level]:
    position, rotation, jacobian = case.chain.pose(q)
    hessian, fraction, period = case.chain.hessian(q), case.fraction, case.period
    away = capped(fraction * (case.position - position), 0.35 * period)
    turn = capped(fraction * log(case.rotation @ rotation.T), 1.5 * period)
    own = {
        "p": (jacobian[:3], away, hessian[:3]),
        "z": (jacobian[1:2], away[1:2], hessian[1:2]),
        "r": (jacobian[3:], turn, hessian[3:]),
        "q": (np.eye(len(q)), np.clip(-fraction * q, -0.8 * period, 0.8 * period), None),
    }
    return [
        Level(name, rows, wanted, second if bent else None, fraction)
        for name, (rows, wanted, second) in ((letter, own[letter]) for letter in case.stack)
    ]


class Outcome(NamedTuple):
    """How the last second went.

    Attributes:
        motion: Largest motion of a joint, rad a tick.
        swing: Largest way of a joint back and forth, rad a tick.
        error: Error of the first level, m or rad.
    """

    motion: float
    swing: float
    error: float


def settle(case: Stretched, *, bent: bool = True, seconds: float = 15.0) -> Outcome:
    q, motions, law = case.start, [], case.law()
    for _ in range(int(seconds / case.period)):
        moved = law.solve(levels(case, q, bent=bent), q).displacement
        q = q + moved
        motions.append(moved)
    position, rotation, _ = case.chain.pose(q)
    errors = {
        "p": np.linalg.norm(case.position - position),
        "z": abs(case.position[1] - position[1]),
        "r": np.linalg.norm(log(case.rotation @ rotation.T)),
    }
    last = np.array(motions[-int(1.0 / case.period) :])
    swing = (np.abs(last).sum(axis=0) - np.abs(last.sum(axis=0))).max() / len(last)
    return Outcome(float(np.abs(last).max()), float(swing), float(errors[case.stack[0]]))


@pytest.mark.parametrize("period", [PERIOD, 0.05])
def test_stacks_on_random_arms_do_not_swing(period: float) -> None:
    cases = [stretched(seed)._replace(period=period) for seed in range(8)]
    swings = [settle(case, seconds=12.0).swing for case in cases]  # one turns back after 9 s
    assert max(swings) <= STILL / 4


def narrow(seed: int) -> Stretched:
    """Sample an arm whose joints turn by 0.3 to 1.2 rad to each side."""
    case, rng = stretched(seed), np.random.default_rng([seed, 7])
    start = np.clip(case.start, -0.25, 0.25)
    return case._replace(limit=float(rng.uniform(0.3, 1.2)), start=start)


@pytest.mark.parametrize("period", [0.02, 0.05])
@pytest.mark.parametrize("seed", [5, 7, 9, 11])
def test_joints_that_hold_a_level_rest_at_their_limits(seed: int, period: float) -> None:
    """Not up to a step before them: the level would end short of the nearest posture, and creep."""
    case = narrow(seed)._replace(stack="p", period=period)
    q, law = case.start, case.law()
    for _ in range(int(15.0 / period)):
        step = law.solve(levels(case, q), q)
        q = q + step.displacement
    assert step.locked.any()
    room = case.limit - LawSettings(1.0).limit_margin - np.abs(q[step.locked])
    np.testing.assert_allclose(room, 0.0, atol=1e-9)


@pytest.mark.slow
def test_nearly_all_stacks_on_random_arms_come_to_rest() -> None:
    """Few leave a saddle of the error after 15 s, ever faster; none of the others moves."""
    outcomes = [settle(stretched(seed)) for seed in range(1000, 1070)]
    assert np.mean([outcome.swing <= STILL / 4 for outcome in outcomes]) >= 0.99
    assert np.mean([outcome.motion <= STILL for outcome in outcomes]) >= 0.97


@pytest.mark.parametrize("share", [0.95, 0.999, 1.001, 1.02, 1.3])
def test_planar_arm_at_the_end_of_its_reach_rests_at_the_nearest_point(share: float) -> None:
    chain = Chain.planar(3, 0.7)
    turned = exp(np.array([0.0, 0.0, 0.5]))
    aim = share * 0.7 * np.array([np.cos(0.4), np.sin(0.4), 0.0])
    case = Stretched(chain, np.array([0.3, 0.4, 0.2]), aim, turned, "prq", 10.0)
    outcome = settle(case, seconds=8.0)
    assert outcome.motion <= STILL
    assert outcome.error == pytest.approx(max(0.0, (share - 1.0) * 0.7), abs=1e-3)


def straight(joints: int, share: float, stack: str) -> Stretched:
    """Return a stretched arm with a target on its axis, at a share of its length."""
    aim = np.array([0.7 * share, 0.0, 0.0])
    return Stretched(Chain.planar(joints, 0.7), np.zeros(joints), aim, np.eye(3), stack, 10.0)


@pytest.mark.parametrize("stack", ["p", "pq", "pr", "prq"])
@pytest.mark.parametrize("share", [-0.6, 0.3, 0.9])
@pytest.mark.parametrize("joints", [3, 6])
def test_arm_stretched_away_from_a_target_on_its_axis_leaves_the_saddle(
    joints: int, share: float, stack: str
) -> None:
    """No step of first order helps, and a lower level that pulls back to the saddle has to wait."""
    case = straight(joints, share, stack)
    outcome = settle(case, seconds=12.0)
    assert outcome.error < 1e-3
    assert outcome.motion <= STILL


def test_arm_leaves_a_saddle_in_spite_of_rounding_encoders_and_lagging_servos() -> None:
    case = straight(4, 0.4, "p")
    assert follow(case, quantum=1e-4) <= STILL
    law, q = case.law(), case.start
    first = [law.solve(levels(case, q), q).displacement.copy() for _ in range(2)]
    assert np.array_equal(*first) and 0.0 < np.abs(first[0]).max() <= 1.5 * PERIOD


def test_step_from_a_saddle_is_no_faster_than_the_request() -> None:
    """Its tip may move aside as fast as the bounds of the task allow."""
    for speed in (0.35, 0.01):
        case = straight(4, 0.4, "p")
        rows, request = case.chain.pose(case.start)[2][:3], np.array([-speed * PERIOD, 0.0, 0.0])
        level = Level("p", rows, request, case.chain.hessian(case.start)[:3], case.fraction)
        moved = case.law().solve([level], case.start).displacement
        assert 0.0 < np.linalg.norm(moved) * np.linalg.norm(rows, 2) <= 1.001 * speed * PERIOD


def test_arm_at_the_end_of_its_reach_has_no_saddle_to_leave() -> None:
    case = straight(4, 1.3, "p")
    assert not case.law().solve(levels(case, case.start), case.start).displacement.any()


def test_first_order_alone_swings_where_the_second_rests() -> None:
    """Otherwise the tests above would pass by themselves."""
    chain, turned = Chain.planar(3, 0.7), exp(np.array([0.0, 0.0, 0.5]))
    aim = np.array([0.9, 0.4, 0.0])
    case = Stretched(chain, np.array([0.3, 0.4, 0.2]), aim, turned, "pr", 10.0)
    swinging, resting = settle(case, bent=False, seconds=8.0), settle(case, seconds=8.0)
    assert swinging.motion > 50 * STILL
    assert resting.motion <= STILL
    assert resting.error < swinging.error


@pytest.mark.parametrize("seed", range(1, 13, 4))
def test_lower_levels_do_not_move_an_unreachable_level_at_rest(seed: int) -> None:
    case = stretched(seed)._replace(stack="prq")
    together, alone = settle(case), settle(case._replace(stack="p"))
    assert together.error <= alone.error + 2e-3


@pytest.mark.parametrize("share", [0.5, 1.0, 1.3])
def test_stretched_arm_that_cannot_press_harder_rests_at_the_largest_force(share: float) -> None:
    """A spring of 100 N/m is 10 cm short of the end of the arm's reach; another level bends it."""
    chain, stiffness, wall, length = Chain.planar(3, 0.7), 100.0, 0.6, 0.7
    largest = stiffness * (length - wall)

    def motion(bent: bool) -> tuple[float, float]:
        fraction, law = (
            8.0 * PERIOD / 2,
            Law(np.full(3, -3.0), np.full(3, 3.0), LawSettings(1.5 * PERIOD)),
        )
        q = np.full(3, 0.3)
        for _ in range(600):
            position, _, rows = chain.pose(q)
            force, bend = stiffness * (position[0] - wall), stiffness * chain.hessian(q)
            press = capped(fraction * np.array([share * largest - force]), 5.0 * PERIOD)
            aside = capped(fraction * np.array([0.1 - position[1]]), 0.35 * PERIOD)
            hessian = bend[:1] if bent else None
            stack = [
                Level("press", stiffness * rows[:1], press, hessian, fraction),
                Level("aside", rows[1:2], aside, chain.hessian(q)[1:2], fraction),
            ]
            moved = law.solve(stack, q).displacement
            q = q + moved
        return float(np.abs(moved).max()), stiffness * (chain.pose(q)[0][0] - wall)

    still, force = motion(bent=True)
    assert still <= STILL
    assert force == pytest.approx(min(share, 1.0) * largest, rel=1e-3)
    if share > 1.0:
        assert motion(bent=False)[0] > 10 * STILL


def follow(case: Stretched, quantum: float, ticks: int = 1200) -> float:
    """Return the motion at rest if encoders round positions and servos lag, rad a tick."""
    law, sizes, count = case.law(), {"p": 3, "r": 3, "z": 1}, case.chain.joints
    q, reference, motions = case.start, case.start.copy(), []
    stack = Stack([(letter, sizes.get(letter, count)) for letter in case.stack], count)
    for _ in range(ticks):
        read = np.round(q / quantum) * quantum
        stack.clock[0] = (stack.clock[0] + 1) % TICKS
        for place, level in enumerate(levels(case, read)):
            stack.put(place, level)
        motions.append(law.compose(stack, read).displacement.copy())
        reference = reference + motions[-1]
        q = q + 0.4 * (reference - q)
    return float(np.abs(motions[-300:]).max())


@pytest.mark.parametrize("seed", [3, 29, 33])
def test_stack_with_rounding_encoders_and_lagging_servos_rests(seed: int) -> None:
    case = stretched(seed)._replace(stack="prq")
    assert follow(case, quantum=1e-4) <= STILL


@njit
def newton_step_of(
    curvature: Floats, basis: Floats, values: Floats, along: Floats, guards: Floats
) -> tuple[Floats, Floats]:
    return newton_step(curvature, basis, 2, values, along, guards, Way(0.0, 1.0, 0.0, 1.0))


@pytest.mark.parametrize("bent_joints", [1, 3, 6])
def test_newton_step_equals_that_in_all_free_directions(
    bent_joints: int, rng: np.random.Generator
) -> None:
    joints, taken, rank, guards = 9, 2, 3, np.array([0.0, 1e-6, 1.0])
    for _ in range(20):
        directions = np.linalg.qr(rng.normal(size=(joints, joints)))[0]
        factor = np.zeros((joints, bent_joints))
        factor[:bent_joints] = rng.normal(size=(bent_joints, bent_joints))
        curvature = factor @ factor.T
        values, along = rng.uniform(0.5, 2.0, rank), rng.normal(size=rank)
        free, pull = directions[taken:], np.zeros(joints - taken)
        stiffness = free @ curvature @ free.T
        stiffness[:rank, :rank] += np.diag(values**2)
        pull[:rank] = values * along
        expected = np.linalg.pinv(stiffness, rcond=1e-10) @ pull @ free
        step, resisted = newton_step_of(curvature, directions.copy(), values, along, guards)
        np.testing.assert_allclose(step, expected, atol=1e-7)
        above = directions[:taken]
        np.testing.assert_allclose(above @ resisted.T, 0.0, atol=1e-9)
        np.testing.assert_allclose(
            resisted.T @ resisted, free.T @ free @ curvature @ free.T @ free, atol=1e-9
        )


@njit
def balance_of(rows: Floats, pull: Floats, pinned: int) -> tuple[Floats, Basis, int]:
    basis, taken, sizes = empty_basis(rows.shape[1], len(rows)), 0, np.zeros(len(rows))
    taken += len(span(rows[:2], basis, taken, 0, sizes[:2]))
    if pinned >= 0:
        locked = np.zeros(rows.shape[1], dtype=np.bool_)
        locked[pinned] = True
        taken = pin_joints(locked, basis, taken)
    taken += len(span(rows[2:], basis, taken, 2, sizes[2:]))
    return balance(pull, basis, taken, rows), basis, taken


@pytest.mark.parametrize("unit", [1.0, 0.05])
@pytest.mark.parametrize("pinned", [-1, 0, 4])
def test_multipliers_balance_a_pull_in_the_span_of_the_levels_above(
    pinned: int, unit: float, rng: np.random.Generator
) -> None:
    rows, weights = unit * rng.normal(size=(4, 7)), rng.normal(size=4)
    pull = rows.T @ weights
    if pinned >= 0:
        pull[pinned] += 2.0
    left = pull.copy()
    multipliers, _, taken = balance_of(rows, left, pinned)
    assert taken == 4 + (pinned >= 0)
    np.testing.assert_allclose(multipliers, weights, rtol=1e-6 / unit**2)
    np.testing.assert_allclose(left, 0.0, atol=1e-6)


def test_multipliers_of_a_free_pull_leave_its_free_part(rng: np.random.Generator) -> None:
    rows, pull = rng.normal(size=(4, 7)), rng.normal(size=7)
    left = pull.copy()
    multipliers, _, _ = balance_of(rows, left, -1)
    np.testing.assert_allclose(multipliers, np.linalg.lstsq(rows.T, pull)[0], rtol=1e-6)
    np.testing.assert_allclose(rows @ left, 0.0, atol=1e-6)


@njit
def add_curvature_of(hessians: Floats, weights: Floats, factor: float, curvature: Floats) -> None:
    add_curvature(hessians, weights, factor, curvature)


@njit
def least_resisted_of(way: Way) -> float:
    return least_resisted(way)


def test_curvature_is_the_weighted_sum_of_hessians(rng: np.random.Generator) -> None:
    hessians, weights, before = rng.normal(size=(3, 4, 4)), np.array([0.5, 0.0, -2.0]), np.eye(4)
    found = before.copy()
    add_curvature_of(hessians, weights, -3.0, found)
    np.testing.assert_allclose(found, before - 3.0 * np.tensordot(weights, hessians, 1))


@pytest.mark.parametrize("weight", [-2.0, -1.0, -0.5, -0.0, 0.5, 1.0, 2.0])
def test_curvature_counts_a_hessian_of_any_weight(weight: float, rng: np.random.Generator) -> None:
    hessians, found = rng.normal(size=(2, 3, 3)), np.zeros((3, 3))
    add_curvature_of(hessians, np.array([weight, 3.0]), 2.0, found)
    np.testing.assert_allclose(found, 2.0 * weight * hessians[0] + 6.0 * hessians[1])


@pytest.mark.parametrize("unit", [1.0, 1e-7, 1e-14])
def test_resisted_directions_span_a_curvature_in_any_unit(
    unit: float, rng: np.random.Generator
) -> None:
    """Rounding is a share of the largest curvature, with some joints that bend nothing."""
    guards, none = np.array([0.0, 1e-6, 1.0]), np.zeros(0)
    for rank in (1, 2, 4):
        curvature = np.zeros((6, 6))
        frame = np.linalg.qr(rng.normal(size=(4, 4)))[0][:rank]
        curvature[1:5, 1:5] = unit * frame.T @ np.diag(rng.uniform(1.0, 2.0, rank)) @ frame
        _, resisted = step_of(curvature, none, none, guards, Way(0.0, 1.0, 0.0, 1.0))
        assert len(resisted) == rank
        np.testing.assert_allclose(resisted.T @ resisted, curvature, atol=1e-9 * unit)


def test_least_resisted_stiffness_is_a_share_of_the_bounded_error() -> None:
    assert least_resisted_of(Way(0.004, 0.05, 9.0, 1.0)) == pytest.approx(0.08e-3)
    assert 0.0 < least_resisted_of(Way(0.0, 0.5, 0.0, 1.0)) < 1e-12


@njit
def step_of(
    curvature: Floats, values: Floats, along: Floats, guards: Floats, way: Way
) -> tuple[Floats, Floats]:
    return newton_step(curvature, np.eye(len(curvature)), 0, values, along, guards, way)


@pytest.mark.parametrize("value", [0.01, 0.039, 0.041, 0.5])
def test_newton_step_is_damped_below_the_threshold_alone(value: float) -> None:
    """Without curvature, it is the damped step of first order."""
    damping, threshold = 0.01, 0.04
    guards, along = np.array([damping, threshold, 1.0]), np.array([0.3])
    step, _ = step_of(np.zeros((2, 2)), np.array([value]), along, guards, Way(0.01, 0.1, 0.1, 0.5))
    divisor = value**2 + damping * max(0.0, 1.0 - value**2 / threshold**2)
    np.testing.assert_allclose(step, [value * 0.3 / divisor, 0.0], atol=1e-12)


@pytest.mark.parametrize("stiffness", [0.4, 0.6])
def test_direction_counts_as_resisted_from_half_of_the_least_stiffness(stiffness: float) -> None:
    way = Way(0.01, 0.1, 0.1, 0.5)
    curvature = np.diag([0.0, stiffness * least_resisted_of(way)])
    guards, none = np.array([0.01, 0.04, 1.0]), np.zeros(1)
    _, resisted = step_of(curvature, np.ones(1), none, guards, way)
    assert len(resisted) == (stiffness > 0.5)
    np.testing.assert_allclose(resisted.T @ resisted, curvature * (stiffness > 0.5), atol=1e-15)


@pytest.mark.parametrize("farther", [1.0, 5.0])
@pytest.mark.parametrize("lever", [0.5, 1.5])
def test_step_down_a_curvature_is_as_long_as_the_request_by_all_rows(
    farther: float, lever: float
) -> None:
    """The whole error bends the rows more than its bounded part, by the ratio of both."""
    requested, fraction, guards = 0.005, 0.1, np.array([0.01, 0.04, 1.0])
    way = Way(requested, fraction, farther * requested / fraction, lever)
    steep = np.array([0.6, -0.8])
    curvature = np.zeros((3, 3))
    curvature[1:, 1:] = -0.02 * np.outer(steep, steep)
    values = np.array([0.5])
    step, resisted = step_of(curvature, values, np.zeros(1), guards, way)
    side = np.sign(step[1])
    np.testing.assert_allclose(step, side * requested / lever * np.array([0, *steep]), atol=1e-9)
    np.testing.assert_allclose(resisted.T @ resisted, -curvature, atol=1e-12)


@pytest.mark.parametrize(("bend", "leaves"), [(-0.2, False), (-0.3, True)])
def test_step_down_a_curvature_needs_more_than_the_rows_of_the_level(
    bend: float, leaves: bool
) -> None:
    """A row of 0.5 outweighs a curvature of -0.2, not one of -0.3."""
    guards, way = np.array([0.01, 0.04, 1.0]), Way(0.005, 0.1, 0.05, 0.5)
    step, _ = step_of(np.diag([bend, 0.0]), np.array([0.5]), np.zeros(1), guards, way)
    assert bool(step.any()) is leaves


@pytest.mark.parametrize(("bend", "leaves"), [(-0.0049, False), (-0.0051, True)])
def test_curvature_below_a_tenth_of_the_error_is_not_left(bend: float, leaves: bool) -> None:
    guards, way = np.array([0.01, 0.04, 1.0]), Way(0.005, 0.1, 0.05, 0.5)
    step, resisted = step_of(np.diag([0.0, bend]), np.array([0.5]), np.zeros(1), guards, way)
    assert (bool(step.any()), len(resisted)) == (leaves, leaves)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("pull", "added"), [(1e-4, True), (0.05, False)])
def test_step_down_a_curvature_is_added_if_the_ordinary_step_gains_less(
    side: float, pull: float, added: bool
) -> None:
    """A second row of 0.01 has a pull along the direction whose curvature is negative."""
    damping, requested, fraction = 0.01, 0.005, 0.1
    guards, values = np.array([damping, 0.04, 1.0]), np.array([0.5, 0.01])
    along = np.array([0.0, side * pull])
    curvature = np.diag([0.0, -0.02])
    way = Way(requested, fraction, requested / fraction, 0.5)
    step, resisted = step_of(curvature, values, along, guards, way)
    assert len(resisted) == added and np.isfinite(resisted).all()
    ordinary = values[1] * along[1] / (1e-4 + damping * (1.0 - 1e-4 / 0.04**2))
    gained = values[1] * along[1] * ordinary / fraction
    length = requested / 0.5
    more = abs(values[1] * along[1]) * length / fraction + 0.5 * (0.02 - 1e-4) * length**2
    assert bool(more > gained) is added
    np.testing.assert_allclose(step[1], ordinary + added * side * length, rtol=1e-6)


def test_level_that_searches_leaves_a_saddle_by_the_way_that_it_requests() -> None:
    guards, curvature = np.array([0.01, 0.04, 1.0]), np.diag([0.0, -0.02])
    steps = [
        step_of(curvature, np.ones(1), np.zeros(1), guards, Way(0.005, 0.1, error, 1.0))[0]
        for error in (0.05, np.nan)
    ]
    assert steps[0].any()
    np.testing.assert_array_equal(*steps)


@pytest.mark.parametrize(
    ("value", "lever", "longest"), [(2.0, 0.5, 2.0), (0.5, 1.5, 1.5), (0.0, 0.0, 0.04)]
)
def test_step_down_a_curvature_is_as_short_as_the_longest_row_needs(
    value: float, lever: float, longest: float
) -> None:
    """Rows shorter than the threshold of the damping count as long as it."""
    guards, values = np.array([0.01, 0.04, 1.0]), np.full(int(value > 0.0), value)
    way, curvature = Way(0.005, 0.1, 0.05, lever), np.diag([0.0, -0.02])
    step, _ = step_of(curvature, values, 0.0 * values, guards, way)
    np.testing.assert_allclose(np.abs(step), [0.0, 0.005 / longest])


@pytest.mark.parametrize("steep", [(0.6, -0.8), (-0.6, 0.8), (0.8, -0.6), (1.0, -1.0), (-1.0, 1.0)])
def test_step_down_a_curvature_without_a_pull_goes_to_the_side_of_its_largest_part(
    steep: tuple[float, float],
) -> None:
    """The first one of equal parts counts, so that rounding does not choose the side."""
    guards, way = np.array([0.01, 0.04, 1.0]), Way(0.005, 0.1, 0.05, 0.5)
    curvature = -0.02 * np.outer(steep, steep)
    step, _ = step_of(curvature, np.full(2, 0.01), np.zeros(2), guards, way)
    assert step[int(abs(steep[1]) > abs(steep[0]))] > 0.0


@pytest.mark.parametrize("steeper", [1, 2])
def test_step_down_a_curvature_takes_the_direction_that_gains_most(steeper: int) -> None:
    guards, way, bends = np.array([0.01, 0.04, 1.0]), Way(0.005, 0.1, 0.05, 0.5), np.full(3, -0.02)
    bends[0], bends[steeper] = 0.0, -0.03
    step, resisted = step_of(np.diag(bends), np.array([0.5]), np.zeros(1), guards, way)
    np.testing.assert_array_equal(np.flatnonzero(step), [steeper])
    np.testing.assert_array_equal(np.flatnonzero(resisted), [steeper])


@pytest.mark.parametrize("fraction", [0.1, 0.9])
def test_step_down_a_curvature_weighs_a_pull_by_the_whole_error(fraction: float) -> None:
    """The second direction is steeper; the first one has a pull, which a farther target raises."""
    guards, along, requested = np.array([0.01, 0.04, 1.0]), np.array([-0.01, 0.0]), 0.005
    way = Way(requested, fraction, requested / fraction, 0.5)
    bends, length, rows = np.array([-0.02, -0.024]), requested / 0.5, np.full(2, 0.001)
    gains = np.abs(rows * along) * length / fraction + 0.5 * np.abs(bends) * length**2
    step, _ = step_of(np.diag(bends), rows, along, guards, way)
    assert int(np.argmax(np.abs(step))) == int(np.argmax(gains))


def test_step_down_a_curvature_without_a_pull_has_a_positive_largest_part_in_any_frame(
    rng: np.random.Generator,
) -> None:
    guards, way = np.array([0.01, 0.04, 1.0]), Way(0.005, 0.1, 0.05, 0.5)
    for _ in range(40):
        frame, _ = np.linalg.qr(rng.normal(size=(5, 5)))
        curvature = frame @ np.diag([-0.03, -0.02, 0.0, 0.01, 0.02]) @ frame.T
        step, _ = step_of(curvature, np.full(5, 1e-4), np.zeros(5), guards, way)
        assert step[np.argmax(np.abs(step))] > 0.0


def test_level_that_requests_nothing_leaves_no_saddle() -> None:
    guards, curvature = np.array([0.01, 0.04, 1.0]), np.diag([0.0, -0.02])
    step, resisted = step_of(curvature, np.ones(1), np.zeros(1), guards, Way(0.0, 0.1, 0.05, 1.0))
    assert not step.any() and len(resisted) == 0


@njit
def resist_of(resisted: Floats, taken: int, least: float, before: int) -> int:
    basis = empty_basis(resisted.shape[1], 1)
    basis.directions[:] = np.eye(resisted.shape[1])
    return resist(resisted, basis, taken, least, before) - taken


@pytest.mark.parametrize(
    ("stiffness", "before", "withheld"),
    [(0.4, 1, 0), (0.6, 0, 0), (0.6, 1, 1), (1.9, 0, 0), (2.1, 0, 1), (2.1, 1, 1)],
)
def test_direction_is_withheld_from_twice_the_least_stiffness_down_to_half(
    stiffness: float, before: int, withheld: int
) -> None:
    resisted = np.sqrt(stiffness * 1e-3) * np.eye(4)[2:3]
    assert resist_of(resisted.copy(), 1, 1e-3, before) == withheld
    assert resist_of(resisted.copy(), 3, 1e-3, before) == 0  # a level above takes it


def test_level_that_begins_to_act_withholds_nothing_by_earlier_ticks() -> None:
    """A count of directions that is left from an earlier action would withhold a weak one."""
    task = Level("p", np.zeros((1, 3)), np.array([0.01]), np.zeros((1, 3, 3)), 0.5)
    task.hessian[0, 1, 1] = -1.3 * 1e-3  # type: ignore[index]
    rest, bound, kept = Level("q", np.eye(3), np.full(3, 0.1)), np.full(3, 1e3), []
    for age in (1, 3):
        stack = Stack.of([task, rest], 3)
        stack.arrays.withheld[0], stack.arrays.ages[0] = 1, age
        Law(-bound, bound, LawSettings(1e3)).compose(stack, np.zeros(3))
        kept.append(int(stack.arrays.withheld[0]))
    assert kept == [0, 1]

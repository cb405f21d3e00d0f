"""The prioritised law: priority, bounded steps, singularities and joint limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.level import Level
from cbdsl.control.potentials.spring import spring
from cbdsl.control.signal import SignalError
from cbdsl.numeric.arrays import Floats
from tests.control.chain import Chain
from tests.control.evaluation import evaluate

WIDE = LawSettings(joint_step=1e3)
TICK = 1 / 120
STACKS = 10_000
DEXTER = LawSettings(joint_step=1.5 * TICK, limit_margin=0.03)

seeds = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module", autouse=True)
def compiled() -> None:
    """Compile the law before the first example."""
    law_of(3).solve([], np.zeros(3))


def rows_of(rng: np.random.Generator, count: int, joints: int) -> Floats:
    """Return rows of a level: dense, or reading some joints, with dependent rows now and then."""
    rows = rng.normal(size=(count, joints))
    if rng.random() < 0.3:
        rows = np.eye(joints)[rng.permutation(joints)[:count]]
    if count > 1 and rng.random() < 0.3:
        rows[-1] = rows[0]
    if rng.random() < 0.1:
        rows[0] = 0.0
    return rows


def random_stack(rng: np.random.Generator, joints: int) -> list[Level]:
    """Return two to six levels; some repeat or mix the rows of the levels above, some nearly so."""
    levels: list[Level] = []
    for i in range(rng.integers(2, 7)):
        rows = rows_of(rng, int(rng.integers(1, min(joints, 7) + 1)), joints)
        above = np.vstack([level.jacobian for level in levels]) if levels else rows
        match rng.choice(["own", "own", "own", "repeated", "mixed", "nearly mixed"]):
            case "repeated":
                rows = above[: len(rows)]
            case "mixed":
                rows = rng.normal(size=(len(rows), len(above))) @ above / len(above)
            case "nearly mixed":  #  all but a few of the digits of their remainder are lost
                mixed = rng.normal(size=(len(rows), len(above))) @ above / len(above)
                rows = mixed + 10.0 ** rng.uniform(-12, -6) * rows
        levels.append(Level(f"level {i}", rows, rng.normal(size=len(rows))))
    return levels


def law_of(joints: int, settings: LawSettings = WIDE, limit: float = np.inf) -> Law:
    return Law(np.full(joints, -limit), np.full(joints, limit), settings)


def prefixes(law: Law, levels: list[Level], q: Floats) -> list[Step]:
    """Return the results for the highest 1, 2, ... levels."""
    return [law.solve(levels[: i + 1], q) for i in range(len(levels))]


@given(seed=seeds, joints=st.integers(3, 14))
def test_lower_levels_do_not_disturb_higher_ones(seed: int, joints: int) -> None:
    rng = np.random.default_rng(seed)
    levels = random_stack(rng, joints)
    above = levels[0].jacobian
    steps = prefixes(law_of(joints), levels, np.zeros(joints))
    for level, upper, lower in zip(levels[1:], steps[:-1], steps[1:], strict=True):
        added = lower.displacement - upper.displacement
        # Rounding scales with the sums that are subtracted here.
        size = max(1.0, float(np.linalg.norm(upper.displacement)), float(np.linalg.norm(added)))
        assert np.linalg.norm(above @ added) <= 1e-12 * size
        above = np.vstack((above, level.jacobian))


def test_no_level_of_ten_thousand_random_stacks_moves_a_higher_one() -> None:
    """Use dependent rows within a level and among levels, by a tick's velocities."""
    rng, worst, dependent = np.random.default_rng(17), 0.0, 0
    for _ in range(STACKS):
        joints = int(rng.integers(3, 15))
        law = law_of(joints)
        levels = [
            level._replace(velocity=0.01 * level.velocity) for level in random_stack(rng, joints)
        ]
        steps = prefixes(law, levels, np.zeros(joints))
        above = np.zeros((0, joints))
        for level, upper, lower in zip(levels, steps[:-1], steps[1:], strict=False):
            above = np.vstack((above, level.jacobian))
            leak = above @ (lower.displacement - upper.displacement)
            worst = max(worst, float(np.sqrt(leak @ leak)))
        dependent += bool((steps[-1].singular_values == 0.0).any())
    assert worst <= 1e-12
    assert dependent > STACKS / 2


@given(seed=seeds, joints=st.integers(3, 14), limit=st.floats(0.02, 2.0))
def test_limits_and_step_bounds_cost_higher_levels_nothing(
    seed: int, joints: int, limit: float
) -> None:
    rng = np.random.default_rng(seed)
    levels = random_stack(rng, joints)
    law = law_of(joints, LawSettings(joint_step=0.5, limit_margin=0.01), limit)
    q = rng.uniform(-limit + 0.01, limit - 0.01, joints)
    above = levels[0].jacobian
    steps = prefixes(law, levels, q)
    for level, upper, lower in zip(levels[1:], steps[:-1], steps[1:], strict=True):
        assert np.linalg.norm(above @ (lower.displacement - upper.displacement)) <= 1e-12
        above = np.vstack((above, level.jacobian))
    for step in steps:
        assert np.abs(step.displacement).max() <= 0.5 + 3e-12
        assert np.abs(q + step.displacement).max() <= limit - 0.01 + 3e-12


@given(seed=seeds, joints=st.integers(3, 14))
def test_independent_levels_are_all_met(seed: int, joints: int) -> None:
    rng = np.random.default_rng(seed)
    rows = np.linalg.qr(rng.normal(size=(joints, joints)))[0] * rng.uniform(0.1, 5, joints)
    cut = int(rng.integers(1, joints))
    levels = [
        Level("high", rows[:cut], rng.normal(size=cut)),
        Level("low", rows[cut:], rng.normal(size=joints - cut)),
    ]
    step = law_of(joints).solve(levels, np.zeros(joints))
    for level, report in zip(levels, step.reports, strict=True):
        np.testing.assert_allclose(level.jacobian @ step.displacement, level.velocity, atol=1e-9)
        assert report.share == pytest.approx(1.0)
        assert report.rank == len(level.velocity)


def test_step_is_shortened_as_a_whole_and_never_for_a_lower_level(
    rng: np.random.Generator,
) -> None:
    high = Level("high", np.eye(2, 7), np.array([0.006, 0.0]))
    low = Level("low", np.eye(7), np.array([0.0, 0.0, 0.03, 0.06, 0.0, 0.0, 0.0]))
    step = law_of(7, DEXTER).solve([high, low], np.zeros(7))
    np.testing.assert_allclose(step.displacement, [0.006, 0, 0.00625, 0.0125, 0, 0, 0], atol=1e-15)
    assert step.reports[0].share == pytest.approx(1.0)


def test_report_of_a_level_states_its_missing_displacement() -> None:
    high = Level("high", np.eye(3, 5), np.zeros(3))
    low = Level("low", np.array([[1.0, 0, 0, 0, 0.5], [0, 1.0, 0, 0, 0]]), np.array([0.1, 0.1]))
    report = law_of(5).solve([high, low], np.zeros(5)).reports[1]
    assert (report.name, report.rank) == ("low", 1)
    assert report.singular_value == pytest.approx(0.5)
    assert report.share == pytest.approx(0.5)


@pytest.mark.parametrize("joints", [3, 7])
def test_steps_are_bounded_and_continuous_through_a_singularity(joints: int) -> None:
    """Straighten and bend a planar arm while it is pulled along its own axis."""
    chain, settings = Chain.planar(joints), LawSettings(joint_step=1e3)
    law = law_of(joints, settings)
    velocity = np.array([0.003, 0.001])
    # Damping keeps each gain below that of an undamped step at the threshold.
    bound = np.linalg.norm(velocity) / settings.singular_value
    bends = np.concatenate((np.linspace(-0.3, 0.3, 1001), [-1e-13, -1e-9, 0.0, 1e-9, 1e-13]))
    bends.sort()
    steps = []
    for bend in bends:
        q = bend * np.cos(np.arange(joints))
        rows = chain.signal("position", q).jacobian[:2]
        steps.append(law.solve([Level("pull", rows, velocity)], q).displacement)
    assert max(np.linalg.norm(step) for step in steps) <= bound * (1 + 1e-9)
    jumps = np.linalg.norm(np.diff(steps, axis=0), axis=1)
    assert jumps.max() <= 0.1 * bound


@given(seed=seeds, joints=st.integers(2, 14))
def test_no_conditioning_makes_a_step_longer_than_the_damping_allows(
    seed: int, joints: int
) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, joints + 1))
    left = np.linalg.qr(rng.normal(size=(count, count)))[0]
    right = np.linalg.qr(rng.normal(size=(joints, joints)))[0][:count]
    rows = left * 10.0 ** rng.uniform(-14, 1, count) @ right
    velocity = rng.normal(size=count)
    step = law_of(joints).solve([Level("task", rows, velocity)], np.zeros(joints)).displacement
    bound = float(np.linalg.norm(velocity)) / WIDE.singular_value
    assert np.linalg.norm(step) <= bound * (1 + 1e-9)


def test_damping_is_zero_away_from_singularities_and_continuous_at_its_threshold() -> None:
    law, threshold = law_of(2), WIDE.singular_value

    def gain(value: float) -> float:
        level = Level("row", np.array([[value, 0.0]]), np.array([1.0]))
        return float(law.solve([level], np.zeros(2)).displacement[0])

    assert gain(2 * threshold) == pytest.approx(1 / (2 * threshold), rel=1e-14)
    assert gain(threshold * (1 - 1e-9)) == pytest.approx(gain(threshold * (1 + 1e-9)), rel=1e-6)
    assert gain(1e-10) == pytest.approx(0.0, abs=1e-7)
    assert gain(0.0) == 0.0


def reach(chain: Chain, q: Floats, goal: Floats) -> tuple[Floats, Floats]:
    """Return planar rows of a spring on the tip, and its residual."""
    evaluation = evaluate(spring("position", 3), chain.signal("position", q), goal)
    return evaluation.jacobian[:2], evaluation.residual[:2]


def test_hand_stays_at_its_goal_against_a_level_that_never_rests() -> None:
    chain = Chain.planar(7)
    law = Law(np.full(7, -2.5), np.full(7, 2.5), DEXTER)
    q = start = np.array([0.4, 0.5, -0.3, 0.6, 0.4, -0.2, 0.5])
    goal, travelled = chain.pose(q)[0], 0.0
    for tick in range(3000):
        rows, error = reach(chain, q, goal)
        wanted = start + 0.3 * np.sin(2.0 * tick * TICK + np.arange(7))
        # A Newton step a tick (kappa = 1), and a hundredth of the way below it. The remainder is
        # of second order: the square of the lower level's displacement in one tick.
        levels = [
            Level("reach", rows, error / 2),
            Level("sway", np.eye(7), 0.01 * (wanted - q)),
        ]
        step = law.solve(levels, q).displacement
        q, travelled = q + step, travelled + float(np.linalg.norm(step))
        assert np.linalg.norm(chain.pose(q)[0] - goal) < 1e-5
    assert travelled > 1.0  # rad: the lower level did move its free joints


def drift(error: Floats) -> Level:
    """Return a lower level that moves every joint, none faster than 0.8 rad/s."""
    rate = error * min(1.0, 0.8 / float(np.abs(error).max()))
    return Level("drift", np.eye(len(error)), rate * TICK)


def test_reach_converges_with_the_other_joints_when_one_meets_its_limit() -> None:
    chain = Chain.planar(7)
    lower, upper = np.full(7, -2.5), np.full(7, 2.5)
    q = np.array([0.1, 0.5, 0.3, 0.4, 0.2, 0.2, 0.3])
    upper[:3] = 0.3, 0.7, 0.6
    goal = chain.pose(np.array([0.2, 0.6, 0.5, 1.2, 0.9, 0.8, 0.4]))[0]
    law = Law(lower, upper, DEXTER)
    ever_locked = np.zeros(7, dtype=bool)
    for _ in range(900):
        rows, error = reach(chain, q, goal)
        levels = [Level("reach", rows, 4 * error * TICK), drift(upper - q)]
        upper_step, step = prefixes(law, levels, q)
        assert np.linalg.norm(rows @ (step.displacement - upper_step.displacement)) <= 1e-12
        q = q + step.displacement
        ever_locked |= upper_step.locked
        assert (q >= lower + 0.03 - 3e-12).all()
        assert (q <= upper - 0.03 + 3e-12).all()
    assert ever_locked.any()
    assert np.linalg.norm(chain.pose(q)[0] - goal) < 1e-4


def test_joints_beyond_their_limits_come_back_at_bounded_speed() -> None:
    chain = Chain.planar(7)
    law = Law(np.full(7, -1.0), np.full(7, 1.0), DEXTER)
    q = np.array([0.2, 1.3, 0.3, -1.2, 0.2, 0.9, 0.3])
    goal = chain.pose(q)[0]
    inside = np.clip(q, -0.97, 0.97)
    for tick in range(200):
        rows, error = reach(chain, q, goal)
        step = law.solve([Level("reach", rows, 4 * error * TICK)], q).displacement
        assert np.abs(step).max() <= DEXTER.joint_step + 3e-12
        outside = np.abs(q) > 0.97 + 1e-11
        assert (step[outside] * q[outside] < 0).all()
        q = q + step
        if tick > 0.36 / DEXTER.joint_step:
            assert (np.abs(q) <= 0.97 + 3e-12).all()
    # The free joints made up for it.
    assert np.linalg.norm(chain.pose(q)[0] - goal) < 1e-3
    assert np.linalg.norm(chain.pose(inside)[0] - goal) > 1e-2


@given(seed=seeds, joints=st.integers(3, 14))
def test_joints_beyond_their_limits_return_for_any_request(seed: int, joints: int) -> None:
    rng = np.random.default_rng(seed)
    law = law_of(joints, DEXTER, 1.0)
    q = rng.uniform(-1.5, 1.5, joints)
    step = law.solve(random_stack(rng, joints), q)
    inside = np.clip(q, -0.97, 0.97)
    outside = np.abs(q - inside) > 1e-9
    needed = np.clip(inside - q, -DEXTER.joint_step, DEXTER.joint_step)[outside]
    moved = step.displacement[outside]
    assert np.abs(step.displacement).max() <= DEXTER.joint_step + 3e-12
    # The speed is at least the needed one: a level may request to go further inside.
    assert (moved * np.sign(needed) >= np.abs(needed) - 3e-12).all()
    assert (np.abs(q + step.displacement)[~outside] <= 0.97 + 3e-12).all()


def test_recovery_at_full_speed_leaves_the_other_joints_their_task(
    rng: np.random.Generator,
) -> None:
    law = Law(np.full(7, -1.0), np.full(7, 1.0), DEXTER)
    q = np.array([0.0, 1.5, 0.0, 0.0, -1.2, 0.0, 0.0])
    level = Level("reach", rng.normal(size=(3, 7)), np.full(3, 1e-3))
    step = law.solve([level], q)
    np.testing.assert_array_equal(np.flatnonzero(step.locked), [1, 4])
    assert step.displacement[1] == pytest.approx(-DEXTER.joint_step)
    assert step.displacement[4] == pytest.approx(DEXTER.joint_step)
    assert step.reports[0].rank == 3
    assert np.abs(np.delete(step.displacement, [1, 4])).min() > 0


def test_joint_at_full_speed_does_not_stop_the_levels_below() -> None:
    """Lower levels have a share in that joint that is only rounding."""
    high = Level("high", np.array([[0.3, 0.1, 0.0, 0.0], [0.1, -0.2, 0.0, 0.0]]), np.ones(2))
    low = Level("low", np.array([[0.7, 0.9, 0.6, 0.8]]), np.array([0.001]))
    first, both = prefixes(law_of(4, DEXTER), [high, low], np.zeros(4))
    assert np.abs(first.displacement).max() == pytest.approx(DEXTER.joint_step)
    assert np.abs(both.displacement[2:]).min() > 1e-4


@given(seed=seeds)
def test_joint_at_full_speed_does_not_shorten_the_motion_of_others(seed: int) -> None:
    """Bring another joint to full speed by the lower level; rounding in the first has no effect."""
    rng = np.random.default_rng(seed)
    rows = np.zeros((2, 4))
    rows[:, :2] = np.eye(2) + rng.uniform(-0.3, 0.3, (2, 2))
    high = Level("high", rows, rows @ np.array([0.1, 0.05, 0.0, 0.0]))
    low = Level("low", rng.uniform(0.5, 1.0, (1, 4)), np.array([0.1]))
    both = law_of(4, DEXTER).solve([high, low], np.zeros(4)).displacement
    assert np.abs(both[:2]).max() == pytest.approx(DEXTER.joint_step)
    assert both[2:].max() == pytest.approx(DEXTER.joint_step)


def test_joint_leaves_its_limit_freely() -> None:
    law = Law(np.full(3, -1.0), np.full(3, 1.0), DEXTER)
    q = np.array([0.9705, 0.0, -0.9705])  # just inside the margin on either side
    levels = [Level("posture", np.eye(3), np.array([-0.01, 0.0, 0.01]))]
    step = law.solve(levels, q)
    np.testing.assert_allclose(step.displacement, [-0.01, 0, 0.01])
    assert not step.locked.any()


def test_without_levels_only_recovery_moves() -> None:
    law = Law(np.full(3, -1.0), np.full(3, 1.0), DEXTER)
    step = law.solve([], np.array([0.5, 2.0, -0.975]))
    np.testing.assert_allclose(step.displacement, [0, -DEXTER.joint_step, 0.005])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_numbers_never_reach_a_joint(bad: float) -> None:
    law, good = law_of(3), Level("reach", np.eye(3), np.zeros(3))
    spoiled = np.array([0.0, bad, 0.0])
    with pytest.raises(SignalError, match="posture"):
        law.solve([good], spoiled)
    for field, value in (("velocity", spoiled), ("jacobian", np.diag(spoiled))):
        with pytest.raises(SignalError, match=f"{field.title()[:4]}.* of reach|{field} of reach"):
            law.solve([good, good._replace(**{field: value})], np.zeros(3))


def test_level_of_another_shape_is_refused() -> None:
    with pytest.raises(SignalError, match="reach wants 2 coordinates of 3 joints"):
        law_of(3).solve([Level("reach", np.eye(3), np.zeros(2))], np.zeros(3))
    with pytest.raises(SignalError, match="reach wants 3 coordinates of 3 joints"):
        law_of(3).solve([Level("reach", np.eye(3, 4), np.zeros(3))], np.zeros(3))


def test_limits_without_room_are_refused() -> None:
    with pytest.raises(ValueError, match="limits"):
        Law(np.zeros(2), np.full(2, 0.01), LawSettings(joint_step=0.01, limit_margin=0.03))

"""Slots in one compiled call equal separate evaluations, bounds and records."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.control.compiled_tick import MOVED, RESTED, UNSOUND, ActingArrays, TickArrays, tick
from cbdsl.control.conditions.predicate import PREDICATE, PREDICATES, settings_of
from cbdsl.control.conditions.rate import bounds_of, displace
from cbdsl.control.law import Law, LawSettings, Step
from cbdsl.control.load_guard import LOAD_GUARD
from cbdsl.control.plan import ControllerPlan, Search, SlotForm
from cbdsl.control.potential import Potential, Rule, interpreted, potential
from cbdsl.control.potentials.manipulability import of_jacobian
from cbdsl.control.potentials.range import between
from cbdsl.control.potentials.spring import spring
from cbdsl.control.slot import IDLE, SEARCH, TRACK
from cbdsl.control.slot_step import _stride
from cbdsl.control.stack import Stack
from cbdsl.kinematics.forward import JOINT
from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.handle import bind
from cbdsl.program.controller import Controller
from cbdsl.sensing.signal_arrays import SensedArrays, SignalArrays, TableArrays, TreeArrays
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import WRITTEN
from cbdsl.sensing.table.table import Form, SignalTable
from cbdsl.types.resource_type import FORCE, ORIENTATION, POSITION, ResourceType, configuration
from tests.control.conditions.test_predicate import Monitor
from tests.control.conditions.test_rate import TICK, controller
from tests.control.evaluation import Signal, evaluate

ALL = 9  # joints
JOINTS = np.array([5, 2, 0, 3, 7])  # the joints that the slots move
ROWS = 3
SEARCHING = Search(False, math.inf, math.nan, ())


class Case(NamedTuple):
    """Potential, the controller that bounds it, and the other settings of its slot."""

    potential: Potential
    controller: Controller
    funnel: Sequence[float] = (0.0, 0.0, 0.0)
    search: Search | None = None
    requires: bool = False

    def value(self, rng: np.random.Generator) -> Floats:
        """Return a random value of its feedback."""
        if self.controller.feedback.type == ORIENTATION:
            return exp(rng.normal(size=ROWS)).ravel()
        return rng.normal(size=2 * ROWS if self.potential.rule == Rule.DESCENT else ROWS)

    def reading(self, rng: np.random.Generator) -> Reading:
        value = self.value(rng)
        rows = ROWS if len(value) == ROWS * ROWS else len(value)
        return Reading(value, rng.normal(size=(rows, ALL)), 0)


def made(name: str, kind: ResourceType, **settings: float) -> Controller:
    return replace(controller(kind, **settings), potential=name)


#: Cases of every bound and every rule.
CASES = [
    Case(spring("position", 3), made("spring", POSITION)),
    Case(spring("position", 3), made("spring", POSITION, speed=0.1, acceleration=1.5)),
    Case(spring("configuration", 3), made("spring", configuration(3), speed=0.1)),
    Case(spring("force", 3), made("spring", FORCE.times(3), speed=0.3)),
    Case(spring("orientation", 3, "z"), made("spring", ORIENTATION, speed=0.4)),
    Case(between(np.full(3, -3.0), np.full(3, 4.0)), made("range", configuration(3))),
    Case(of_jacobian(2, 3), made("manipulability", configuration(3), speed=0.2)),
]


class Bench:
    """Slots over rows that a test writes, highest priority first."""

    def __init__(self, cases: Sequence[Case], rng: np.random.Generator) -> None:
        self.cases, self.table, self.plan = cases, SignalTable(ALL), ControllerPlan()
        self.feedback, self.reference, self.windows = [], [], rng.uniform(0.02, 0.1, len(cases))
        for case, window in zip(cases, self.windows, strict=True):
            drawn = case.reading(rng)
            assert drawn.jacobian is not None
            self.feedback.append(
                self.table.bind(Form(WRITTEN, len(drawn.value), len(drawn.jacobian)))
            )
            self.reference.append(self.table.bind(Form(WRITTEN, len(drawn.value), 0)))
            self.plan.add(
                SlotForm(
                    case.potential,
                    bounds_of(case.controller, TICK),
                    settings_of(1e-3, window, TICK),
                    self.feedback[-1],
                    self.reference[-1],
                    case.funnel,
                    case.search,
                    case.requires,
                )
            )
        sizes = [(str(i), case.potential.size) for i, case in enumerate(cases)]
        self.stack = Stack(sizes, len(JOINTS))
        self.step = Step.of(self.stack)
        mine = rng.random((len(cases), len(JOINTS))) < 0.7
        self.columns = np.where(mine, JOINTS, -1)
        self.acting = np.array([(slot, -1, -1, slot) for slot in range(len(cases))])
        self.positions, self.references = np.zeros(ALL), np.zeros(ALL)
        self.steps = np.zeros(len(JOINTS))
        self.law = Law(np.full(5, -1e3), np.full(5, 1e3), LawSettings(joint_step=1e3))
        self.loads, self.load_guards = np.zeros((0, 6)), np.zeros(0, LOAD_GUARD)

    def write(self, place: int, reading: Reading, reference: Floats | None, stamp: int = 0) -> None:
        self.table.write(self.feedback[place], reading._replace(stamp=stamp))
        if reference is not None:
            self.table.write(self.reference[place], Reading(reference, None, 0))

    def draw(self, rng: np.random.Generator, stamp: int = 0) -> None:
        """Let everything be defined."""
        for place, case in enumerate(self.cases):
            self.write(place, case.reading(rng), case.value(rng), stamp)

    def tick(self) -> int:
        table, stack, step, law = self.table, self.stack, self.step, self.law
        feeling = np.zeros(len(self.loads), np.bool_)
        signals = SignalArrays(
            SensedArrays(self.positions, self.loads, feeling),
            TableArrays(table.records, table.parts, table.support, table.value, table.jacobian),
            TreeArrays(np.zeros(0, JOINT), np.zeros((1, 12)), np.zeros((0, 3))),
        )
        acting = ActingArrays(
            np.zeros(0, np.int64), np.zeros(1, np.int64), self.acting, self.columns, JOINTS,
            self.steps, np.zeros(0, np.int64),
        )  # fmt: skip
        arrays = TickArrays(
            signals, self.plan.arrays, acting, stack.arrays, law.arrays(step), self.references,
            self.load_guards, None,
        )  # fmt: skip
        return bind(tick, arrays)()

    def predicates(self) -> str:
        return "".join(PREDICATES[note] for note in self.plan.slots["notes"][:, PREDICATE])


class Alone:
    """One case in turn: evaluated, bounded and noted."""

    def __init__(self, case: Case, window: float, columns: np.ndarray) -> None:
        self.case, self.columns = case, columns
        self.bounds = bounds_of(case.controller, TICK)
        self.displacement = np.zeros(case.potential.size)
        self.monitor = Monitor(1e-3, window, TICK)

    def tick(self, reading: Reading, reference: Floats, stamp: int) -> tuple[float, float, Floats]:
        """Return phi, error and rows."""
        assert reading.jacobian is not None
        jacobian = np.where(self.columns >= 0, reading.jacobian[:, self.columns], 0.0)
        found = evaluate(self.case.potential, Signal(reading.value, jacobian), reference)
        rows, scale = found.jacobian, 1.0
        if self.case.potential.rule != Rule.RESIDUAL:
            scale = 1.0 / float(np.linalg.norm(rows))
        assert displace(
            found.step.copy(), found.residual, scale * rows, scale, self.bounds, self.displacement
        )
        self.monitor.update(found.phi, stamp)
        return found.phi, float(np.linalg.norm(found.residual)), scale * rows


@pytest.fixture
def bench(rng: np.random.Generator) -> Bench:
    return Bench(CASES, rng)


def test_ripple_is_the_change_of_phi_by_steps_of_the_encoders(
    bench: Bench, rng: np.random.Generator
) -> None:
    bench.draw(rng)
    bench.steps[:] = rng.uniform(1e-6, 1e-4, len(JOINTS))
    assert bench.tick() == MOVED
    for place, case in enumerate(bench.cases):
        here, there = bench.feedback[place], bench.reference[place]
        columns = bench.columns[place]
        rows = np.where(columns >= 0, bench.table.rows(here)[:, columns], 0.0)
        signal = Signal(bench.table.values(here), rows)
        found = evaluate(case.potential, signal, bench.table.values(there))
        is_residual = case.potential.rule == Rule.RESIDUAL
        slope = found.jacobian.T @ (found.residual if is_residual else np.ones(1))
        expected = np.abs(slope) @ bench.steps
        assert bench.plan.slots["ripple"][place] == pytest.approx(expected)


def test_slots_of_one_tick_act_as_separate_slots(bench: Bench, rng: np.random.Generator) -> None:
    alone = [
        Alone(case, window, columns)
        for case, window, columns in zip(CASES, bench.windows, bench.columns, strict=True)
    ]
    streams = [[case.reading(rng) for _ in range(8)] for case in CASES]
    references = [case.value(rng) for case in CASES]
    for now in range(30):
        # Nothing changes from the eighth tick on, and some slots come to rest.
        readings = [stream[min(now, 7)] for stream in streams]
        for place, reading in enumerate(readings):
            bench.write(place, reading, references[place], stamp=now)
        assert bench.tick() == MOVED
        expected = [
            one.tick(reading, reference, now)
            for one, reading, reference in zip(alone, readings, references, strict=True)
        ]
        slots, stack = bench.plan.slots, bench.stack
        np.testing.assert_allclose(slots["phi"], [phi for phi, _, _ in expected], rtol=1e-9)
        np.testing.assert_allclose(slots["error"], [error for _, error, _ in expected], rtol=1e-9)
        rows = np.vstack([rows for _, _, rows in expected])
        np.testing.assert_allclose(stack.rows[stack.newest], rows, atol=1e-9)
        wanted = np.concatenate([one.displacement for one in alone])
        np.testing.assert_allclose(stack.wanted, wanted, atol=1e-12)
        assert stack.ages.tolist() == [min(now + 1, 3)] * len(CASES)
        assert bench.predicates() == "".join(one.monitor.predicate for one in alone)
    assert set(bench.predicates()) == {"1"}


def test_references_move_by_the_laws_displacement(bench: Bench, rng: np.random.Generator) -> None:
    bench.draw(rng)
    assert bench.tick() == MOVED
    assert bench.step.displacement.any()
    np.testing.assert_array_equal(bench.references[JOINTS], bench.step.displacement)
    assert not np.delete(bench.references, JOINTS).any()


def test_mode_of_a_slot_follows_its_definedness_and_search(rng: np.random.Generator) -> None:
    """Undefined slots are idle, or search if there is something to move for."""
    searching = [case._replace(search=SEARCHING) for case in CASES[:4]]
    bench = Bench([CASES[0], *searching], rng)
    for now in range(2):
        bench.draw(rng, now)
        bench.table.forget(bench.feedback[0])
        bench.write(1, CASES[0].reading(rng)._replace(measured=now == 0), None, now)
        bench.table.forget(bench.feedback[2])
        bench.table.forget(bench.reference[3])
        assert bench.tick() == MOVED
    assert bench.plan.slots["mode"].tolist() == [IDLE, SEARCH, IDLE, IDLE, TRACK]
    # A slot that was defined and searches counts as defined for the slots that require it.
    assert bench.plan.slots["engaged"].tolist() == [False, True, False, False, True]
    assert bench.stack.ages.tolist() == [0, 2, 0, 0, 2]
    assert np.isfinite(bench.plan.slots["phi"]).tolist() == [False, False, False, False, True]
    assert bench.predicates() == "----0"


def test_feedback_without_a_moving_joint_is_undefined(
    bench: Bench, rng: np.random.Generator
) -> None:
    bench.draw(rng)
    reading = CASES[0].reading(rng)
    assert reading.jacobian is not None
    reading.jacobian[:, bench.columns[0][bench.columns[0] >= 0]] = 0.0
    bench.write(0, reading, None)
    assert bench.tick() == MOVED
    assert bench.plan.slots["mode"].tolist() == [IDLE, *[TRACK] * (len(CASES) - 1)]


def test_tick_without_acting_slots_moves_nothing(bench: Bench) -> None:
    assert bench.tick() == RESTED
    assert bench.predicates() == "-" * len(CASES)
    assert not bench.references.any()


def test_slot_acts_only_while_its_required_slot_acts(rng: np.random.Generator) -> None:
    bench = Bench([CASES[0], CASES[1]._replace(requires=True)], rng)
    bench.draw(rng)
    for condition, defined, engaged in ((-1, True, False), (0, True, True), (0, False, False)):
        bench.acting[1, 2] = condition
        if not defined:
            bench.table.forget(bench.feedback[0])
        bench.tick()
        assert bool(bench.plan.slots["engaged"][1]) == engaged
        assert (bench.plan.slots["mode"][1] == TRACK) == engaged


def test_search_begins_once_its_leader_is_near_and_ends_with_its_joints(
    rng: np.random.Generator,
) -> None:
    follower = CASES[1]._replace(search=Search(True, 0.1, 0.5, (4, 8)))
    bench = Bench([CASES[0], follower], rng)
    bench.acting[1, 1] = 0
    leading = CASES[0].reading(rng)
    found = []
    for error, angle in ((0.2, 0.0), (0.09, 0.0), (0.2, 0.0), (0.2, 0.6), (0.05, 0.0)):
        bench.write(0, leading, leading.value + np.array([error, 0.0, 0.0]))
        bench.write(1, follower.reading(rng)._replace(measured=False), np.zeros(3))
        # One of both joints beyond the end is not enough.
        bench.positions[[4, 8]] = 0.6, angle
        bench.tick()
        slot = bench.plan.slots[1]
        found.append((int(slot["mode"]), bool(slot["exhausted"])))
    # A search goes on once begun, and is over once without success.
    assert found == [(IDLE, False), (SEARCH, False), (SEARCH, False), (IDLE, True), (IDLE, True)]
    bench.write(1, follower.reading(rng), None)
    bench.tick()
    assert bench.plan.slots["mode"][1] == TRACK
    assert not bench.plan.slots["exhausted"][1]


def test_motion_rests_only_while_its_required_contact_is_measured(
    rng: np.random.Generator,
) -> None:
    bench = Bench([CASES[1]._replace(search=SEARCHING), CASES[0]._replace(requires=True)], rng)
    bench.acting[1, 2] = 0
    hold, motion = (case.reading(rng) for case in bench.cases)
    found, longest = [], round(2.0 / TICK)
    for stamp in range(1, 80 + longest):
        bench.write(0, hold._replace(measured=stamp < 60), hold.value, stamp)
        bench.write(1, motion, motion.value, stamp)
        bench.tick()
        found.append(bench.predicates()[1])
    assert found[58] == "1"
    # It goes on while contact is sought again, and is undefined once that takes too long.
    assert set(found[59 : 58 + longest]) == {"0"}
    assert set(found[60 + longest :]) == {"-"}


def test_slot_with_a_lost_feedback_restarts_from_rest(rng: np.random.Generator) -> None:
    bench, first = Bench(CASES[1:2], rng), CASES[1].reading(rng)
    wanted = []
    for now in range(6):
        bench.write(0, first, np.full(3, 9.0), now)
        if now == 4:
            bench.table.forget(bench.feedback[0])
        bench.tick()
        wanted.append(float(np.linalg.norm(bench.plan.before)))
    assert wanted[0] == wanted[5] > wanted[4] == 0.0
    assert wanted[3] > 3 * wanted[0]


def test_interrupted_search_continues_at_its_speed(rng: np.random.Generator) -> None:
    bench = Bench([CASES[1]._replace(search=SEARCHING)], rng)
    sought, found = CASES[1].reading(rng)._replace(measured=False), []
    for now in range(6):
        bench.write(0, sought, np.full(3, 9.0), now)
        if now == 4:
            bench.table.forget(bench.feedback[0])
        bench.tick()
        found.append((int(bench.plan.slots["mode"][0]), float(np.linalg.norm(bench.plan.before))))
    modes, wanted = zip(*found, strict=True)
    assert modes == (SEARCH, SEARCH, SEARCH, SEARCH, IDLE, SEARCH)
    assert wanted[5] > wanted[3] == wanted[4] > wanted[0]


@pytest.mark.parametrize("spike", [0.05, 1.0, 30.0, 1e6])
def test_references_after_a_spike_of_an_encoder_move_within_their_steps(
    spike: float, rng: np.random.Generator
) -> None:
    """Neither the lead nor the limits may pull a reference further than its step."""
    bench = Bench([CASES[0], CASES[2]], rng)
    step, limit = 0.02, 2.0
    bench.law = Law(np.full(5, -limit), np.full(5, limit), LawSettings(joint_step=step, lead=0.1))
    steps = []
    for number in range(40):
        bench.draw(rng, number)
        bench.positions[:] = bench.references
        if number % 5 == 4:
            bench.positions[rng.choice(JOINTS)] += spike * rng.choice([-1.0, 1.0])
        before = bench.references.copy()
        assert bench.tick() == MOVED
        steps.append(np.abs(bench.references - before).max())
    assert 0.5 * step < max(steps) <= step + 1e-9


def test_funnel_raises_the_target_and_the_error_uses_the_reference(
    rng: np.random.Generator,
) -> None:
    raised = CASES[0]._replace(funnel=(0.2, 0.01, 3.0))
    bench = Bench([raised, CASES[0]], rng)
    bench.columns[1] = bench.columns[0]
    reading = raised.reading(rng)
    reference = reading.value + np.array([0.03, 0.04, 0.3])
    height = 3.0 * (0.05 - 0.01)
    bench.write(0, reading, reference)
    bench.write(1, reading, reference + np.array([0.0, 0.0, height]))
    bench.tick()
    np.testing.assert_allclose(bench.stack.wanted[:3], bench.stack.wanted[3:], atol=1e-12)
    assert bench.plan.slots["error"][0] == pytest.approx(math.hypot(0.05, 0.3))


@pytest.mark.parametrize("place", range(len(CASES)))
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_tick_with_a_non_finite_row_fails_and_moves_nothing(
    bench: Bench, place: int, bad: float, rng: np.random.Generator
) -> None:
    bench.draw(rng)
    bench.columns[place] = JOINTS
    bench.table.rows(bench.feedback[place])[1, JOINTS[0]] = bad
    assert bench.tick() == place
    assert not bench.references.any()
    assert bench.stack.ages.tolist() == [1] * place + [0] * (len(CASES) - place)
    bench.draw(rng)
    assert bench.tick() == MOVED


def test_numbers_too_large_for_the_law_move_nothing(bench: Bench, rng: np.random.Generator) -> None:
    bench.draw(rng)
    bench.positions[JOINTS[0]] = math.nan
    assert bench.tick() == UNSOUND
    assert not bench.references.any()


@pytest.mark.parametrize("size", [1e-6, 1e-2, 10.0])
def test_short_gradient_moves_the_joints_by_gain_times_itself(
    size: float, rng: np.random.Generator
) -> None:
    """Distinguish a short gradient from a singularity."""
    case = Case(of_jacobian(1, 3), made("manipulability", configuration(3), gain=2.0))
    bench = Bench([case._replace(potential=of_jacobian(2, 3))], rng)
    bench.columns[0] = JOINTS
    rows = np.zeros((6, ALL))
    # w = s t of two rows of lengths s and t at right angles; only the first changes, by joint 5.
    rows[0, 5] = size
    bench.write(0, Reading(np.array([0.5, 0, 0, 0, 3.0, 0]), rows, 0), np.zeros(6))
    assert bench.tick() == MOVED
    expected = np.where(JOINTS == 5, 2.0 * 3.0 * size * TICK, 0.0)
    np.testing.assert_allclose(bench.step.displacement, expected, rtol=1e-9)


def test_potential_at_its_minimum_requests_no_motion(rng: np.random.Generator) -> None:
    bench = Bench(CASES[-1:], rng)
    # A joint that changes w only to second order: at the optimum.
    rows = np.zeros((6, ALL))
    rows[1, JOINTS] = 1.0
    bench.columns[0] = JOINTS
    bench.write(0, Reading(np.array([0.5, 0, 0, 0, 3.0, 0]), rows, 0), np.zeros(6))
    assert bench.tick() == MOVED
    assert not bench.stack.wanted.any()


def test_another_potential_runs_without_compiling_the_tick_again(
    bench: Bench, rng: np.random.Generator
) -> None:
    @potential
    def towards(
        value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
    ) -> float:
        if parameters[0] < 0.0:
            raise ValueError("a weight is negative")
        for i in range(len(residual)):
            residual[i] = parameters[0] * (reference[i] - value[i])
            slope[i, i] = parameters[0]
        return 0.5 * residual[0] ** 2

    bench.draw(rng)
    bench.tick()
    versions = len(tick.overloads)  # type: ignore[attr-defined]
    weighted = Potential(towards, 3, parameters=np.array([2.0]))
    own = Bench([CASES[0]._replace(potential=weighted)], rng)
    own.draw(rng)
    assert own.tick() == MOVED
    assert len(tick.overloads) == versions  # type: ignore[attr-defined]
    own.plan.parameters[0] = -1.0
    with pytest.raises(ValueError, match="a weight is negative"):
        own.tick()


@pytest.mark.parametrize(
    ("slope", "now", "stride", "expected"),
    [
        (-1.0, -0.5, 0.5, 0.525),  # short of the lowest point: longer
        (-1.0, -0.5, 1.0, 1.0),
        (-1.0, 1.0, 1.0, 0.5),  # as far beyond it as it was before it: half
        (-1.0, 0.25, 0.5, 0.4),
        (-0.01, 1.0, 1.0, 0.2),  # at most by a factor of 5
        (0.5, 1.0, 0.4, 0.42),  # moved away by others: no verdict
    ],
)
def test_stride_shortens_by_the_secant_where_a_step_went_too_far(
    slope: float, now: float, stride: float, expected: float
) -> None:
    way = np.array([0.0, 2.0])
    last, gradient = np.array([7.0, slope / 2]), np.array([-3.0, now / 2])
    assert interpreted(_stride)(stride, last, gradient, way) == pytest.approx(expected)

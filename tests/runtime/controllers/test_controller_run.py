"""One controller while it runs: references, standoffs, funnels and when it has settled."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cbdsl.control.level import Level
from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.program.controller import Controller, Literal, Relative
from cbdsl.robot.resources import resources
from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.sensing.signals import Signals
from cbdsl.types.resource import NetForces, Tip
from cbdsl.types.source_record import chains_of
from tests.conftest import Checked
from tests.runtime.conftest import TABLE_BALL, made_stage
from tests.runtime.synthetic import Ball, SyntheticBackend, World

PERIOD = 1 / 60


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument, urdf: Path) -> SyntheticBackend:
    return SyntheticBackend(dexter, urdf)


@pytest.fixture(scope="module")
def reachtouch(checked: Checked) -> CheckedProgram:
    return checked("reachtouch")


@pytest.fixture
def signals(
    dexter: RobotDocument,
    kinematics: Kinematics,
    reachtouch: CheckedProgram,
    backend: SyntheticBackend,
) -> Signals:
    """Return signals after one look at the ball on the table."""
    signals = Signals(dexter, kinematics, resources_of(reachtouch))
    look_at(Ball(TABLE_BALL), signals, backend)
    return signals


def look_at(ball: Ball | None, signals: Signals, backend: SyntheticBackend) -> None:
    backend.reset(made_stage({}), None, np.random.default_rng(0))
    backend.world = World(ball)
    signals.reset()
    signals.update(backend.observe())


class Started:
    """Controller that acts by itself, with its actuation."""

    def __init__(self, robot: RobotDocument, controller: Controller, signals: Signals) -> None:
        plan = ControllerPlan()
        self.run = ControllerRun(controller, signals, plan, PERIOD)
        self._signals, self._active = signals, (Active(self.run, {}),)
        self._actuation = Actuation(robot, signals, plan, PERIOD)
        self._actuation.reset(signals.positions)
        self.run.begin(np.random.default_rng(3))
        self.run.activate()

    def tick(self) -> Level | None:
        """Return its requested level in one tick, without any effect."""
        self._actuation.reference[:] = self._signals.positions
        self._actuation.move(self._active)
        step = self._actuation.step
        return None if step is None else step.levels[0]


@pytest.fixture
def start(dexter: RobotDocument, signals: Signals) -> Callable[[Controller], Started]:
    return lambda controller: Started(dexter, controller, signals)


Start = Callable[[Controller], Started]


def approach_of(program: CheckedProgram) -> Controller:
    return program.primitives["reach"].lead


@pytest.mark.parametrize("radius", [0.03, 0.07, 0.1, 0.2])
def test_standoff_grows_with_the_seen_radius_between_its_bounds(
    reachtouch: CheckedProgram,
    signals: Signals,
    backend: SyntheticBackend,
    start: Start,
    radius: float,
) -> None:
    # The distance lets both cameras see all of it.
    camera = signals.kinematics.frame("left_camera")
    look_at(Ball(camera.position + 1.8 * camera.rotation[:, 0], radius), signals, backend)
    approach = replace(approach_of(reachtouch), funnel=None)
    started = start(approach)
    run = started.run
    started.tick()
    palm = signals.kinematics.frame("right_palm")
    tip = palm.position + palm.rotation @ np.array([0, -0.006, 0])
    assert approach.standoff is not None
    standoff = np.clip(radius + approach.standoff.clearance, 0.09, 0.14)
    memory = signals.vision.memories["sat_10"]
    assert memory.radius == pytest.approx(radius, rel=0.1)
    control_point = tip + standoff * palm.rotation[:, 2]
    expected = np.linalg.norm(memory.position - control_point)
    assert run.error == pytest.approx(expected, abs=0.1 * radius)


@pytest.mark.parametrize("lateral", [0.0, 0.01, 0.03, 0.3])
def test_funnel_leads_to_its_reference_from_above(
    reachtouch: CheckedProgram, signals: Signals, start: Start, lateral: float
) -> None:
    """Beside the reference it goes up, the more the farther; over it straight down."""
    approach = replace(approach_of(reachtouch), standoff=None)
    funnel = approach.funnel
    assert funnel is not None
    source = approach.feedback.source
    assert isinstance(source, Tip)
    here = signals.tips.point(source.effector).position
    signals.vision.memories["sat_10"].position = here + np.array([lateral, 0, -0.05])
    started = start(approach)
    run = started.run
    level = started.tick()
    height = min(max(funnel.slope * (lateral - funnel.within), 0.0), funnel.height)
    wanted = np.array([lateral, 0, height - 0.05])
    assert level is not None
    velocity = level.velocity
    assert velocity / np.linalg.norm(velocity) == pytest.approx(wanted / np.linalg.norm(wanted))
    # The funnel raises the way, not the reference: the error ignores the added height.
    assert run.error == pytest.approx(math.hypot(lateral, 0.05))


def test_sample_is_kept_until_it_was_reached(
    checked: Checked, signals: Signals, backend: SyntheticBackend, start: Start
) -> None:
    started = start(checked("searchtrack").primitives["search"].lead)
    run = started.run
    started.tick()
    first = run.error
    for _ in range(3):
        run.activate()
        started.tick()
        assert run.error == first
    # Nothing moves, so that it comes to rest.
    for _ in range(30):
        signals.update(backend.observe())
        started.tick()
    assert run.predicate == "1"
    run.activate()
    started.tick()
    assert run.predicate == "0"
    assert run.error != first


def test_samples_lie_within_the_joint_limits_and_differ(
    checked: Checked, signals: Signals, start: Start
) -> None:
    search = checked("searchtrack").primitives["search"].lead
    errors = []
    for _ in range(20):
        started = start(search)
        run = started.run
        for _ in range(3):
            started.tick()
            errors.append(run.error)
            run.predicate = "1"
            run.activate()
    own = signals.joints.pick(search.joints)
    limits = signals.kinematics
    here = signals.positions[own]
    reach = np.linalg.norm(np.maximum(limits.upper[own] - here, here - limits.lower[own]))
    assert max(errors) <= reach
    assert len(set(errors)) == 3


def test_literal_orientation_is_a_rotation_vector(
    reachtouch: CheckedProgram, signals: Signals, start: Start
) -> None:
    """Turn the palm down; its error is the angle of its normal."""
    orient = reachtouch.primitives["reach"].controllers[1]
    started = start(orient)
    run = started.run
    started.tick()
    normal = signals.kinematics.frame("right_palm").rotation[:, 2]
    assert run.error == pytest.approx(math.acos(np.clip(-normal[2], -1, 1)), abs=1e-6)


def test_literal_pose_is_a_position_and_a_rotation_vector(
    dexter: RobotDocument, reachtouch: CheckedProgram, signals: Signals, start: Start
) -> None:
    pose = resources(dexter)["right_arm.pose"]
    where, turn = np.array([0.4, -0.1, 0.2]), math.pi / 2
    controller = replace(
        approach_of(reachtouch),
        feedback=pose,
        chains=chains_of(pose),
        reference=Literal((*where, 0.0, 0.0, turn)),
        standoff=None,
        funnel=None,
    )
    started = start(controller)
    run = started.run
    started.tick()
    found = signals.read(pose)
    assert found is not None
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    cosine = (np.trace(quarter @ found.value[:3, :3].T) - 1) / 2
    shift = np.linalg.norm(where - found.value[:3, 3])
    assert run.error == pytest.approx(math.hypot(shift, math.acos(cosine)))


@pytest.mark.parametrize("share", [0.0, 0.4, 0.79, 0.81, 0.9, 1.6])
def test_controller_settles_within_a_share_of_its_reference(
    dexter: RobotDocument,
    reachtouch: CheckedProgram,
    signals: Signals,
    backend: SyntheticBackend,
    start: Start,
    share: float,
) -> None:
    """Give fingers ``share`` of their reference force, so that they miss ``1 - share`` of it."""
    touch = reachtouch.primitives["touch"].lead
    started = start(touch)
    run = started.run
    forces = 2.0 * share * signals.touch.shares("right_hand")
    cells = dexter.load_cells["right_hand"].items()
    for force, (finger, cell) in zip(forces, cells, strict=True):
        normal = signals.kinematics.frame(cell.link).rotation @ np.array(cell.normal)
        backend.world.broken["right_hand", finger] = np.r_[force * normal, np.zeros(3)]
    signals.update(backend.observe())
    started.tick()
    if share == 0.0:
        assert run.predicate == "-"
        assert not run.settled
        return
    assert touch.quiescence.within == 0.2
    assert run.error == pytest.approx(abs(1 - share) * 2 * np.linalg.norm([0.53, 0.53, 1]))
    assert run.settled == (abs(1 - share) < 0.2)


@pytest.mark.parametrize("tolerance", [0.01, 10.0])
def test_controller_settles_within_its_tolerance(
    reachtouch: CheckedProgram,
    signals: Signals,
    start: Start,
    tolerance: float,
) -> None:
    approach = approach_of(reachtouch)
    quiescence = approach.quiescence._replace(tolerance=tolerance)
    signals.vision.memories["sat_10"].position = np.array([0.5, -0.2, -0.3])
    started = start(replace(approach, quiescence=quiescence))
    run = started.run
    started.tick()
    assert 0.01 < run.error < 10.0
    assert run.settled == (tolerance == 10.0)


@pytest.mark.parametrize(("tolerance", "predicate"), [(0.01, "0"), (10.0, "1")])
def test_controller_run_at_constant_potential_is_quiescent_only_within_its_tolerance(
    reachtouch: CheckedProgram,
    signals: Signals,
    start: Start,
    tolerance: float,
    predicate: str,
) -> None:
    approach = approach_of(reachtouch)
    quiescence = approach.quiescence._replace(tolerance=tolerance)
    signals.vision.memories["sat_10"].position = np.array([0.5, -0.2, -0.3])
    started = start(replace(approach, quiescence=quiescence))
    # Nothing moves between the ticks, so that the potential is constant.
    for _ in range(100):
        signals.clock[0] += 1
        started.tick()
    assert started.run.predicate == predicate


@pytest.mark.parametrize(
    ("arrival", "arrived"), [((0.01,), False), ((10.0,), True), ((math.inf,), True)]
)
def test_controller_at_rest_has_arrived_only_within_its_arrival(
    reachtouch: CheckedProgram,
    signals: Signals,
    start: Start,
    arrival: tuple[float, ...],
    arrived: bool,
) -> None:
    signals.vision.memories["sat_10"].position = np.array([0.5, -0.2, -0.3])
    started = start(replace(approach_of(reachtouch), arrival=arrival))
    started.tick()
    assert not started.run.arrived and not started.run.stuck
    for _ in range(100):
        signals.clock[0] += 1
        started.tick()
    assert started.run.predicate == "1"
    assert (started.run.arrived, started.run.stuck) == (arrived, not arrived)


@pytest.mark.parametrize(
    ("shift", "turn", "arrived"),
    [(0.019, 0.08, True), (0.021, 0.0, False), (0.0, 0.09, False), (0.0, 0.0, True)],
)
def test_controller_of_a_pose_has_arrived_by_its_distance_and_its_angle(
    dexter: RobotDocument,
    reachtouch: CheckedProgram,
    signals: Signals,
    start: Start,
    shift: float,
    turn: float,
    arrived: bool,
) -> None:
    pose = resources(dexter)["right_arm.pose"]
    approach = approach_of(reachtouch)
    still = Relative(None, (shift, 0.0, 0.0, 0.0, turn, 0.0))
    quiescence = approach.quiescence._replace(rate=1e3)
    controller = replace(
        approach, feedback=pose, chains=chains_of(pose), reference=still, standoff=None,
        funnel=None, quiescence=quiescence, arrival=pose.type.arrivals,
    )  # fmt: skip
    started = start(controller)
    for _ in range(100):
        signals.clock[0] += 1
        started.tick()
    assert started.run.predicate == "1"
    assert (started.run.arrived, started.run.stuck) == (arrived, not arrived)


def test_controller_without_a_reference_is_undefined_and_requests_nothing(
    reachtouch: CheckedProgram, signals: Signals, backend: SyntheticBackend, start: Start
) -> None:
    look_at(None, signals, backend)
    started = start(approach_of(reachtouch))
    run = started.run
    assert started.tick() is None
    assert (run.predicate, math.isnan(run.phi), math.isnan(run.error)) == ("-", True, True)


def test_joints_other_than_the_effectors_count_as_still(
    checked: Checked, dexter: RobotDocument, kinematics: Kinematics, backend: SyntheticBackend
) -> None:
    """Eq 3.21: fingers move the net forces of the hands too, but pressing is up to the arms."""
    squeeze = checked("bimanualgrab").primitives["squeeze"].lead
    assert isinstance(squeeze.feedback.source, NetForces)
    signals, plan = Signals(dexter, kinematics, [squeeze.feedback]), ControllerPlan()
    look_at(None, signals, backend)
    fingers = checked("reachtouch").primitives["touch"].lead
    runs = [ControllerRun(each, signals, plan, PERIOD) for each in (squeeze, fingers)]
    actuation = Actuation(dexter, signals, plan, PERIOD)
    actuation.reset(signals.positions)
    for hand, cells in dexter.load_cells.items():
        for finger in cells:
            backend.world.broken[hand, finger] = np.r_[2.0, 2.0, 2.0, np.zeros(3)]
    signals.update(backend.observe())
    for run in runs:
        run.begin(np.random.default_rng(0))
    actuation.move(tuple(Active(run, {}) for run in runs))
    assert actuation.step is not None
    level = actuation.step.levels[0]
    arms, hands = signals.joints.of("arms"), signals.joints.of("hands")
    assert signals.table.rows(runs[0].rows.feedback)[:, hands].any()
    (columns,) = np.nonzero(level.jacobian.any(axis=0))
    moved = signals.joints.pick([*squeeze.joints, *fingers.joints])
    assert set(moved[columns]) <= set(arms)
    assert len(columns) > 7
    assert set(actuation.step.levels[1].jacobian.any(axis=0).nonzero()[0]).isdisjoint(columns)


def test_deactivated_controller_keeps_no_state(
    reachtouch: CheckedProgram, signals: Signals, backend: SyntheticBackend, start: Start
) -> None:
    orient = reachtouch.primitives["reach"].controllers[1]
    used, new = start(orient), start(orient)
    for _ in range(30):
        signals.update(backend.observe())
        used.tick()
    assert used.run.predicate == "1"
    used.run.deactivate()
    assert used.run.predicate == "X"
    used.run.activate()
    for _ in range(3):
        ours, theirs = used.tick(), new.tick()
        assert ours is not None and theirs is not None
        assert ours.velocity == pytest.approx(theirs.velocity)
        assert (used.run.predicate, used.run.error) == (new.run.predicate, new.run.error)


def test_reappeared_object_is_approached_from_rest(
    reachtouch: CheckedProgram, signals: Signals, backend: SyntheticBackend, start: Start
) -> None:
    """Ignore its speed before the loss, which does not describe the robot's present speed."""
    approach = replace(approach_of(reachtouch), funnel=None, standoff=None)
    memory = signals.vision.memories["sat_10"]
    started, rates = start(approach), []
    for tick in range(40):
        signals.update(replace(backend.observe(), images={}))
        memory.position = None if tick == 30 else TABLE_BALL
        level = started.tick()
        rates.append(0.0 if level is None else float(np.linalg.norm(level.velocity)))
    assert approach.acceleration is not None
    step = approach.acceleration * PERIOD**2
    assert rates[29] > 5 * step
    assert rates[30] == 0.0
    assert rates[0] == rates[31] == pytest.approx(step)


def test_undefined_value_is_reported_with_the_resource_and_the_reason(
    checked: Checked, dexter: RobotDocument, kinematics: Kinematics, backend: SyntheticBackend
) -> None:
    program = checked("visualinspect")
    (resolve,) = {
        each
        for action in program.actions
        for each in (action.composition.controllers if action.composition else ())
        if each.name == "resolve"
    }
    signals = Signals(dexter, kinematics, resources_of(program))
    look_at(Ball(TABLE_BALL), signals, backend)
    run = Started(dexter, resolve, signals).run
    text = "the localizability of cameras.sat_10 cannot be computed"
    assert str(run.refuse()).startswith(f"{text}: the lines of sight do not meet")
    run._potential = replace(run._potential, refuse=None)
    assert str(run.refuse()) == text
    for values, what in (
        (signals.table.values(run.rows.feedback), "the value"),
        (signals.table.rows(run.rows.feedback), "the Jacobian"),
    ):
        kept = values.copy()
        values[:] = np.nan
        assert str(run.refuse()).startswith(f"{what} of cameras.sat_10")
        values[:] = kept

"""From levels to joint references: lead, limits, and who is left alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.causes import BLOCKED, CREEPING, Balance
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from tests.conftest import Checked
from tests.runtime.conftest import Play, Played, on_table

# A rounding of joint angles, rad.
SLACK = 1e-9


@pytest.fixture(scope="module")
def touched(checked: Checked, play: Play) -> Played:
    return play(checked("reachtouch"), joints={"pan": 0.9})


def references(played: Played) -> np.ndarray:
    return np.array(played.backend.applied)


def positions(played: Played) -> np.ndarray:
    """Return the positions of the joints when each reference was made."""
    return np.array([each.positions for each in played.observations[:-1]])


def test_references_move_within_the_joint_speed(touched: Played, dexter: RobotDocument) -> None:
    steps = np.abs(np.diff(references(touched), axis=0))
    fastest = dexter.control.joint_speed * touched.backend.control_period
    assert 0.5 * fastest < steps.max() <= fastest + SLACK


def test_references_keep_the_margin_to_the_limits(
    touched: Played, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    found, margin = references(touched), dexter.control.limit_margin
    moved = found.max(axis=0) > found.min(axis=0)
    assert moved.sum() > 10
    assert (found >= kinematics.lower + margin - SLACK)[:, moved].all()
    assert (found <= kinematics.upper - margin + SLACK)[:, moved].all()


def test_joints_without_a_controller_do_not_move(touched: Played, kinematics: Kinematics) -> None:
    for effector in ("left_arm", "left_hand"):
        found = references(touched)[:, kinematics.joints.of(effector)]
        assert (found == found[0]).all()


def test_reference_of_a_blocked_joint_does_not_run_away(
    checked: Checked, play: Play, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    def begin(rng: np.random.Generator) -> object:
        world = on_table()
        world.blocked = ("right_arm_1", "right_arm_5")
        return world

    played = play(checked("posture"), begin)
    leads = np.abs(references(played) - positions(played))
    blocked = kinematics.joints.pick(("right_arm_1", "right_arm_5"))
    assert leads.max() <= dexter.control.lead + SLACK
    assert leads[-1, blocked] == pytest.approx(dexter.control.lead)


def test_same_controllers_with_others_are_another_composition(
    checked: Checked, dexter: RobotDocument, urdf: Path
) -> None:
    """Require a seeking controller to read only controllers that act in its composition."""
    program = checked("reachtouch")
    signals = Signals(dexter, Kinematics(dexter, urdf), resources_of(program))
    plan = ControllerPlan()
    run = ProgramRun(program, signals, plan, 1 / 60)
    run.begin(np.random.default_rng(0), lambda transition: None)
    run.activate()
    together = run.active()
    alone = tuple(item._replace(peers={}) for item in together)
    actuation = Actuation(dexter, signals, plan, 1 / 60)
    actuation.reset(np.zeros(len(signals.joints)))
    found = [actuation._batch(active) for active in (together, alone, together)]
    assert found[0].runs == found[1].runs
    assert found[0] is found[2] is not found[1]
    assert (found[0].acting[:, 1:3] >= 0).any()
    assert (found[1].acting[:, 1:3] == -1).all()


@pytest.mark.parametrize(("behind", "kind"), [(0.0, CREEPING), (1e-3, BLOCKED)])
def test_joint_is_blocked_if_it_lags_behind_earlier_ticks_alone(
    checked: Checked, dexter: RobotDocument, urdf: Path, monkeypatch: pytest.MonkeyPatch,
    behind: float, kind: str,
) -> None:  # fmt: skip
    """The step of the same tick may exceed half of the lead."""
    program, lead = checked("posture"), 5e-4
    robot = dexter.model_copy(update={"control": dexter.control.model_copy(update={"lead": lead})})
    signals = Signals(robot, Kinematics(robot, urdf), resources_of(program))
    plan = ControllerPlan()
    run = ProgramRun(program, signals, plan, 1 / 60)
    run.begin(np.random.default_rng(0), lambda transition: None)
    run.activate()
    actuation = Actuation(robot, signals, plan, 1 / 60)
    actuation.reset(signals.positions)
    actuation.move(run.active())
    assert actuation.step is not None
    assert np.abs(actuation.step.displacement).max() > 0.5 * lead
    actuation.reference += behind
    monkeypatch.setattr(Balance, "cause", lambda self, place: None)
    cause = actuation.cause(run.active()[0].run)
    assert cause is not None and cause.kind == kind


@pytest.mark.parametrize(("angle", "end"), [(1.7, "upper"), (-1.7, "lower")])
def test_target_beyond_a_limit_stops_at_the_limit_and_is_reported(
    written: Callable[..., CheckedProgram],
    play: Play,
    dexter: RobotDocument,
    kinematics: Kinematics,
    angle: float,
    end: str,
) -> None:
    program = written(
        f"controllers: {{turn: {{potential: spring, reference: [{angle} rad, 0.5 rad], "
        "feedback: head, effector: head, speed: 3 rad/s}}\n"
        "actions: [turn]\npolicy: {X: turn, '0': turn}\n"
    )
    held: list[tuple[str, ...]] = []

    def watch(tick: Tick) -> None:
        held.append(tick.actuation.at_limits())

    played = play(program, watch=watch)
    margin = dexter.control.limit_margin
    sign = 1 if end == "upper" else -1
    limit = getattr(kinematics, end)[0] - sign * margin
    assert references(played)[-1, :2] == pytest.approx([limit, 0.5], abs=0.05)
    assert held[-1] == ("pan",)
    assert held[0] == ()
    assert "at their limits were pan" in played.result.ending


def test_joint_past_its_margin_comes_back_at_the_joint_speed(
    checked: Checked, play: Play, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    pan = kinematics.joints.index["pan"]
    start = float(kinematics.upper[pan])
    played = play(checked("searchtrack"), joints={"pan": start})
    found = np.r_[start, references(played)[:, pan]]
    fastest = dexter.control.joint_speed * played.backend.control_period
    assert found.min() < start - dexter.control.limit_margin
    assert np.abs(np.diff(found)).max() <= fastest + SLACK


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("ticks", [pytest.param(300), pytest.param(3000, marks=pytest.mark.slow)])
def test_hand_keeps_its_place_while_the_arm_turns_at_a_lower_level(
    written: Callable[..., CheckedProgram], dexter: RobotDocument, urdf: Path, ticks: int, seed: int
) -> None:
    """With Dexter's own gains, an arm turns as far towards any posture as the hand lets it."""
    kinematics = Kinematics(dexter, urdf)
    signals = Signals(dexter, kinematics, ())
    positions = np.zeros(len(signals.joints))
    own = signals.joints.of("right_arm")
    positions[own] = dexter.effectors["right_arm"].postures["ready"]
    inside = kinematics.lower[own] + 0.05, kinematics.upper[own] - 0.05
    goals = np.random.default_rng(seed).uniform(*inside).tolist()

    def place(positions: np.ndarray) -> np.ndarray:
        kinematics.update(positions)
        return signals.tips.point("right_arm").position

    goal = place(positions)
    program = written(
        "controllers:\n"
        f"  hold: {{potential: spring, reference: [{', '.join(f'{x!r} m' for x in goal.tolist())}],"
        " feedback: right_arm.position, effector: right_arm.position}\n"
        f"  turn: {{potential: spring, reference: [{', '.join(f'{x!r} rad' for x in goals)}],"
        " feedback: right_arm, effector: right_arm}\n"
        "  held: turn ◁ hold\n"
        "actions: [held]\npolicy: {X: held}\n"
    )
    period = 1 / dexter.control.rate
    plan = ControllerPlan()
    run = ProgramRun(program, signals, plan, period)
    run.begin(np.random.default_rng(0), lambda transition: None)
    run.activate()
    actuation = Actuation(dexter, signals, plan, period)
    actuation.reset(positions)
    loads = {
        (name, finger): np.zeros(6) for name, cells in dexter.load_cells.items() for finger in cells
    }
    turned = 0.0
    for _ in range(ticks):
        before = actuation.reference.copy()
        signals.update(Observation(0.0, before, np.zeros(len(before)), loads, {}))
        actuation.move(run.active())
        turned += float(np.abs(actuation.reference - before).max())
        assert np.linalg.norm(place(actuation.reference) - goal) < 1e-5
    assert turned > 0.3

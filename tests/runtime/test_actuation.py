"""From levels to joint references: lead, limits, and who is left alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.robot.kinematics import Kinematics
from cbdsl.runtime.episode import Tick
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
    """Where the joints were when each reference was made."""
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


def test_joints_of_no_controller_stay_where_they_are(
    touched: Played, kinematics: Kinematics
) -> None:
    for effector in ("left_arm", "left_hand"):
        found = references(touched)[:, kinematics.joints.of(effector)]
        assert (found == found[0]).all()


def test_the_reference_of_a_blocked_joint_does_not_run_away(
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


@pytest.mark.parametrize(("angle", "end"), [(9.0, "upper"), (-9.0, "lower")])
def test_beyond_a_limit_it_goes_as_far_as_it_may_and_says_so(
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


def test_a_joint_past_its_margin_comes_back_at_the_joint_speed(
    checked: Checked, play: Play, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    pan = kinematics.joints.index["pan"]
    start = float(kinematics.upper[pan])
    played = play(checked("searchtrack"), joints={"pan": start})
    found = np.r_[start, references(played)[:, pan]]
    fastest = dexter.control.joint_speed * played.backend.control_period
    assert found.min() < start - dexter.control.limit_margin
    assert np.abs(np.diff(found)).max() <= fastest + SLACK

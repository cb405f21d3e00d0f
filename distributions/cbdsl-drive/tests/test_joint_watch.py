"""Joint watch: each bound of the contract, on both of its sides."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cbdsl.api.reading.robots import read_robot
from cbdsl.extend.driver import JointSample
from cbdsl.robot.urdf_reader import parse_urdf, read_urdf
from cbdsl_drive.joint_limits import joint_limits
from cbdsl_drive.joint_watch import JointWatch
from tests.driven_robot import NAMES, URDF, robot

EPOCH = 1.7e9
SKEW, DEADLINE = 0.2, 0.1


def watch(**driver: object) -> JointWatch:
    document = robot(**{"skew": SKEW, "deadline": DEADLINE, **driver})
    return JointWatch(document, joint_limits(document, parse_urdf(URDF, Path("rail.urdf"))))


def note(watch: JointWatch, now: float, **changes: object) -> str:
    sample = JointSample("arm", EPOCH + now, NAMES, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    return watch.note(sample._replace(**changes), now, EPOCH + now)


# The first joint turns by 1 rad at 2 rad/s and 10 N m, with a soft limit of 0.05 rad, twice the
# speed, and 5 % of the effort.
@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"positions": (1.04, 0.0)}, ""),
        ({"positions": (1.06, 0.0)}, "joint 'first' is at 1.060, outside of its limits"),
        ({"positions": (-1.06, 0.0)}, "joint 'first' is at -1.060, outside of its limits"),
        ({"velocities": (3.9, 0.0)}, ""),
        ({"velocities": (-4.1, 0.0)}, "joint 'first' moves at -4.100/s"),
        ({"efforts": (10.4, 0.0)}, ""),
        ({"efforts": (-10.6, 0.0)}, "joint 'first' has the effort -10.60"),
        ({"efforts": (math.nan, 0.0)}, ""),
        ({"efforts": (math.inf, 0.0)}, "joint 'first' has the effort inf"),
        ({"stamp": EPOCH + 0.19}, ""),
        ({"stamp": EPOCH + 0.21}, "0.210 s ahead of"),
        ({"stamp": EPOCH - 0.29}, ""),
        ({"stamp": EPOCH - 0.31}, "0.310 s behind"),
        ({"stamp": math.nan}, "stamped nan s"),
        ({"positions": (math.inf, 0.0)}, "sends inf in positions of joint 'first'"),
        ({"velocities": (0.0, math.nan)}, "sends nan in velocities of joint 'second'"),
        ({"positions": ()}, "sends 0 positions for 2 joints"),
        ({"velocities": ()}, ""),
        ({"efforts": ()}, ""),
        ({"velocities": (0.0,)}, "sends 1 velocities for 2 joints"),
        ({"efforts": (0.0, 0.0, 0.0)}, "sends 3 efforts for 2 joints"),
        ({"names": ("first", "first")}, "names joint 'first' twice"),
        ({"names": ("third", "fourth")}, ""),
    ],
)
def test_joint_watch_distrusts_states_beyond_a_bound(
    changes: dict[str, object], problem: str
) -> None:
    found = note(watch(), 0.0, **changes)
    assert (problem in found) if problem else (found == "")


def test_joint_watch_derives_missing_velocities_from_the_second_state_on() -> None:
    joints = watch()
    assert note(joints, 0.0, positions=(0.5, 0.0), velocities=()) == ""
    assert joints.velocities == pytest.approx([0.0, 0.0])
    assert note(joints, 0.02, positions=(0.52, 0.0), velocities=()) == ""
    assert joints.velocities == pytest.approx([1.0, 0.0])
    assert "moves at 5.000/s" in note(joints, 0.04, positions=(0.62, 0.0), velocities=())


@pytest.mark.parametrize(("pause", "doubled"), [(0.09, True), (0.11, False)])
def test_joint_watch_distrusts_two_sources_within_the_deadline(pause: float, doubled: bool) -> None:
    joints = watch()
    assert note(joints, 0.0, source=1) == ""
    assert note(joints, 0.05, source=1) == ""
    found = note(joints, 0.05 + pause, source=2)
    assert bool(found) is doubled


@pytest.mark.parametrize(("age", "late"), [(0.09, False), (0.11, True)])
def test_joint_watch_names_the_joint_that_is_overdue(age: float, late: bool) -> None:
    joints = watch()
    note(joints, 0.0)
    only = {"names": ("first",), "positions": (0.0,), "velocities": (0.0,), "efforts": (0.0,)}
    note(joints, age, **only)
    found = joints.overdue(age)
    assert found.startswith("no new state of joint 'second'") is late
    assert joints.stamp == EPOCH, "the oldest joint counts"


@pytest.mark.parametrize(
    ("still", "moved", "frozen"), [(0.07, 0.03, True), (0.05, 0.03, False), (0.07, 0.01, False)]
)
def test_joint_watch_finds_frozen_states_of_moving_references(
    still: float, moved: float, frozen: bool
) -> None:
    joints = watch()
    note(joints, 0.0)
    assert joints.frozen(np.zeros(2)) == ""
    note(joints, still)
    assert bool(joints.frozen(np.array([moved, 0.0]))) is frozen


@pytest.mark.parametrize(("distance", "refused"), [(0.09, False), (0.11, True), (math.nan, True)])
def test_joint_watch_refuses_a_first_reference_beyond_the_start(
    distance: float, refused: bool
) -> None:
    joints = watch(start=0.1)
    note(joints, 0.0)
    assert bool(joints.start_errors(np.array([0.0, -distance]))) is refused


@pytest.mark.parametrize(
    ("joint", "frozen"), [("left_finger_1", False), ("left_finger_2", False), ("pan", True)]
)
def test_fingers_that_press_stand_still_without_being_frozen(joint: str, frozen: bool) -> None:
    document, urdf = read_robot("dexter")
    joints = JointWatch(document, joint_limits(document, read_urdf(urdf)))
    zeros = (0.0,) * len(joints.names)
    for now in (0.0, 0.07):
        joints.note(JointSample("body", EPOCH + now, joints.names, zeros, zeros), now, EPOCH + now)
        references = np.where(np.array(joints.names) == joint, now, 0.0)
        found = joints.frozen(references)
    assert bool(found) is frozen

"""Way back: hands that let go, and arms that return where they came from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.turned_posture import start_positions
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_drive.joint_limits import joint_limits
from cbdsl_drive.way_back import WayBack
from tests.backends.conftest import URDF
from tests.driven_robot import robot

PERIOD = 1 / 60


@pytest.fixture(scope="module")
def kinematics(dexter: RobotDocument) -> Kinematics:
    return Kinematics(dexter, URDF)


@pytest.fixture
def way_back(dexter: RobotDocument, kinematics: Kinematics) -> WayBack:
    return made(dexter, kinematics, URDF)


def made(document: RobotDocument, kinematics: Kinematics, urdf: Path) -> WayBack:
    model = read_urdf(urdf)
    return WayBack(document, model, kinematics, joint_limits(document, model))


def moved(start: np.ndarray, way_back: WayBack, columns: np.ndarray, *points: float) -> np.ndarray:
    """Move joints by offsets in turn, as an episode would; return where they are."""
    way_back.begin(start)
    here = start.copy()
    for point in points:
        for at in np.linspace(here[columns], start[columns] + point, 60):
            here[columns] = at
            way_back.note(here)
    return here


@given(points=st.lists(st.floats(-0.6, 0.6), min_size=1, max_size=6))
def test_way_back_is_slow_passes_known_configurations_and_ends_at_the_goal(
    points: list[float], dexter: RobotDocument, kinematics: Kinematics
) -> None:
    way_back, start = made(dexter, kinematics, URDF), start_positions(dexter, kinematics)
    arm = kinematics.joints.of("right_arm")
    here = moved(start, way_back, arm, *points)
    assert way_back.is_known(here)
    references = np.array([here, *way_back.references(way_back.points(here, start), PERIOD)])
    assert references[-1] == pytest.approx(start)
    speeds = np.abs(np.diff(references, axis=0)) / PERIOD
    assert (speeds <= 0.5 * kinematics.speed + 1e-6).all()
    low, high = min(0.0, *points) - 0.051, max(0.0, *points) + 0.051
    offsets = references[:, arm] - start[arm]
    assert ((offsets >= low) & (offsets <= high)).all()


def test_loops_of_the_way_are_cut_off(
    way_back: WayBack, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    start, arm = start_positions(dexter, kinematics), kinematics.joints.of("right_arm")
    once = moved(start, way_back, arm, 0.5)
    short = len([*way_back.references(way_back.points(once, start), PERIOD)])
    often = moved(start, way_back, arm, 0.5, -0.5, 0.5, 0.1, 0.5)
    assert len([*way_back.references(way_back.points(often, start), PERIOD)]) == pytest.approx(
        short, abs=5
    )


def test_hands_open_before_arms_move_and_close_at_the_start(
    way_back: WayBack, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    start, joints = start_positions(dexter, kinematics), kinematics.joints
    arm, fingers = joints.of("right_arm"), joints.of("right_hand")[1:]
    way_back.begin(start)
    here = start.copy()
    # The hand opens wider than its start, reaches, and closes on something.
    for finger, reach in [(0.05, 0.0), (0.05, 0.4), (0.9, 0.4)]:
        here[fingers], here[arm] = finger, start[arm] + reach
        way_back.note(here)
    references = np.array([*way_back.references(way_back.points(here, start), PERIOD)])
    moves = np.abs(references[:, arm] - here[arm]).max(axis=1) > 1e-9
    returned = np.abs(references[:, arm] - start[arm]).max(axis=1) < 1e-9
    assert references[moves & ~returned][:, fingers] == pytest.approx(0.05)
    assert references[-1, fingers] == pytest.approx(start[fingers])


def test_way_is_unknown_before_an_episode_and_after_a_push(
    way_back: WayBack, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    start = start_positions(dexter, kinematics)
    assert not way_back.is_known(start)
    way_back.begin(start)
    assert way_back.is_known(start)
    start[kinematics.joints.of("left_arm")] += 0.3
    assert not way_back.is_known(start)


def test_arm_on_an_unknown_way_rises_upright_and_then_goes_to_the_goal(
    way_back: WayBack, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    start, tip = start_positions(dexter, kinematics), dexter.effectors["right_arm"].tip
    assert tip is not None
    here = start.copy()
    here[kinematics.joints.of("right_arm")] = dexter.effectors["right_arm"].postures["ready"]
    points = way_back.points(here, start)
    assert not way_back.is_known(here)
    tips = [kinematics.posed(point, lambda: kinematics.frame(tip.link)) for point in points]
    rises = np.array([frame.position - tips[0].position for frame in tips])
    assert rises[-3] == pytest.approx([0.0, 0.0, 0.12], abs=0.02)
    assert tips[-3].rotation == pytest.approx(tips[0].rotation, abs=0.05)
    assert points[-1] == pytest.approx(start)
    others = np.delete(np.array(points), kinematics.joints.of("right_arm"), axis=1)
    assert np.ptp(others, axis=0) == pytest.approx(0.0)


BOX = '<collision><origin xyz="{} 0"/><geometry><box size="0.2 0.1 0.1"/></geometry></collision>'
SWINGING = f"""<robot name="swinging">
<link name="base">{BOX.format("0 0.4")}</link><link name="one">{BOX.format("0.4 0")}</link>
<link name="two"/>
<joint name="first" type="revolute"><parent link="foot"/><child link="one"/><axis xyz="0 0 1"/>
<limit lower="-4" upper="4" velocity="2" effort="10"/></joint>
<joint name="second" type="revolute"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="5"/></joint>
<link name="foot"/><link name="post">{BOX.format("0 0.4")}</link>
<joint name="standing" type="fixed"><parent link="root"/><child link="post"/></joint>
<joint name="turning" type="fixed"><parent link="root"/><child link="foot"/></joint>
<link name="root"/>
</robot>"""


def test_straight_way_through_the_robot_itself_is_found(tmp_path: Path) -> None:
    path = tmp_path / "swinging.urdf"
    path.write_text(SWINGING.replace(f'<link name="base">{BOX.format("0 0.4")}</link>', ""))
    document = robot().model_copy(update={"base": "root"})
    way_back = made(document, Kinematics(document, path), path)
    before, beyond = np.array([0.5, 0.0]), np.array([2.6, 0.0])
    assert way_back.self_contact([before, beyond]) == ("one", "post")
    assert way_back.self_contact([before, np.array([-1.0, 0.0])]) is None

"""Turned postures: every side of a held object around the last joint's axis faces the cameras."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.turned_posture import TurnedPosture
from cbdsl.numeric.arrays import Floats
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

#: Fewest joints with which an arm places its last axis across the lines of sight of two cameras.
FEWEST = 6


def _arms() -> Iterator[tuple[str, str]]:
    """Yield each shipped robot with cameras, with each of its arms that can turn in place."""
    library = Library(ROOT)
    for path in sorted((ROOT / "robots").glob("*.yaml")):
        robot = library.read(path, RobotDocument).document
        tipped = [
            name
            for name, each in robot.effectors.items()
            if each.tip is not None and len(each.joints) >= FEWEST
        ]
        yield from ((robot.name, name) for name in tipped if robot.cameras)


ARMS = list(_arms())


class Arm:
    """Arm in its turned posture, and in those on the way of its last joint to it."""

    def __init__(self, robot: str, effector: str) -> None:
        library = Library(ROOT)
        path = library.locate(RobotDocument, robot)
        self.robot = library.read(path, RobotDocument).document
        self.kinematics = Kinematics(self.robot, path.parent / self.robot.model)
        self.own = self.kinematics.joints.of(effector)
        self.turned = TurnedPosture(self.robot, self.kinematics, effector).find()
        self.tip = self.robot.effectors[effector].tip
        self.start = np.array(
            self.robot.effectors[effector].postures[str(self.robot.effectors[effector].start)]
        )

    def place(self, last: float) -> tuple[Floats, Floats, list[Floats]]:
        """Return the tip's rotation, the last joint's axis, and the lines of sight, all units."""
        positions = np.zeros(len(self.kinematics.joints))
        for name, effector in self.robot.effectors.items():
            if effector.start is not None:
                own = self.kinematics.joints.of(name)
                positions[own] = effector.postures[effector.start]
        positions[self.own] = [*self.turned[:-1], last]
        self.kinematics.update(positions)
        assert self.tip is not None
        point = self.kinematics.point(self.tip.link, self.tip.offset)
        rotation = self.kinematics.frame(self.tip.link).rotation
        frames = [self.kinematics.frame(each.link) for each in self.robot.cameras.values()]
        lines = [point.position - frame.position for frame in frames]
        self.headings = [f.rotation.T @ line for f, line in zip(frames, lines, strict=True)]
        return rotation, point.jacobian[3:, self.own[-1]], [e / np.linalg.norm(e) for e in lines]


@pytest.fixture(params=ARMS, ids=" ".join)
def arm(request: pytest.FixtureRequest) -> Arm:
    return Arm(*request.param)


def test_robots_with_one_and_with_two_arms_are_tested() -> None:
    assert {("dexter", "left_arm"), ("dexter", "right_arm"), ("panda", "arm")} <= {*ARMS}


def test_turned_posture_keeps_off_the_joint_limits(arm: Arm) -> None:
    lower, upper = arm.kinematics.lower[arm.own], arm.kinematics.upper[arm.own]
    margins = np.minimum(arm.turned - lower, upper - arm.turned) / (upper - lower)
    assert margins[:-1].min() > 0.09
    assert margins[-1] == pytest.approx(0.02)


def test_turned_posture_has_the_axis_across_the_lines_of_sight_and_the_tip_in_view(
    arm: Arm,
) -> None:
    _, axis, lines = arm.place(arm.turned[-1])
    for line, heading, camera in zip(lines, arm.headings, arm.robot.cameras.values(), strict=True):
        assert abs(math.degrees(math.asin(axis @ line))) < 15
        assert abs(math.atan2(heading[1], heading[0])) < math.atan2(
            camera.width / 2, camera.focal_length
        )
        assert abs(math.atan2(heading[2], heading[0])) < math.atan2(
            camera.height / 2, camera.focal_length
        )


def test_turning_the_last_joint_shows_every_side_around_its_axis(arm: Arm) -> None:
    # Sides of the held object, fixed to the tip.
    rotation, axis, _ = arm.place(arm.turned[-1])
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    angles = np.linspace(0, 2 * math.pi, 16, endpoint=False)
    second = np.cross(axis, first)
    sides = [rotation.T @ (math.cos(a) * first + math.sin(a) * second) for a in angles]
    best = np.full(len(sides), -1.0)
    for last in np.linspace(arm.start[-1], arm.turned[-1], 40):
        rotation, _, lines = arm.place(last)
        shown = [max(float(-(rotation @ side) @ line) for line in lines) for side in sides]
        best = np.maximum(best, shown)
    # One of the cameras sees it from at most 80 degrees off its normal.
    assert best.min() > math.cos(math.radians(80))

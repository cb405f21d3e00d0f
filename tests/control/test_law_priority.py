"""Priority on real arms: displacements by lower levels move no level above them."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.yaml_text.library import Library, shipped

STACKS = 10_000
ROBOTS = sorted(path.stem for path in (shipped() / "robots").glob("*.yaml"))


class Arms:
    """A robot's joints, and the rows that its tips and configurations have."""

    def __init__(self, name: str) -> None:
        library = Library(shipped())
        path = library.locate(RobotDocument, name)
        robot = library.read(path, RobotDocument).document
        self.kinematics = Kinematics(robot, path.parent / robot.model)
        self._tips = [part.tip.link for part in robot.effectors.values() if part.tip is not None]
        self._configurations = [self.kinematics.joints.of(name) for name in robot.effectors]

    def posture(self, rng: np.random.Generator) -> Floats:
        """Return a posture anywhere between the limits, or stretched out straight."""
        lower, upper = self.kinematics.lower, self.kinematics.upper
        q = rng.uniform(lower, upper)
        return np.clip(q * rng.choice([0.0, 1e-6, 1.0], p=[0.05, 0.05, 0.9]), lower, upper)

    def rows(self, rng: np.random.Generator) -> Floats:
        """Return rows of a tip's position, heading, orientation, pose, a configuration, or any."""
        tip = self.kinematics.jacobian(self._tips[rng.integers(len(self._tips))])
        own = self._configurations[rng.integers(len(self._configurations))]
        match rng.integers(6):
            case 0:
                return tip[:3]
            case 1:
                return tip[4:]
            case 2:
                return tip[3:]
            case 3:
                return tip
            case 4:
                return np.eye(tip.shape[1])[own]
            case _:
                return rng.normal(size=(rng.integers(1, 4), tip.shape[1]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_no_level_of_a_random_stack_moves_a_higher_one(name: str, rng: np.random.Generator) -> None:
    arms = Arms(name)
    joints = len(arms.kinematics.lower)
    law = Law(np.full(joints, -np.inf), np.full(joints, np.inf), LawSettings(joint_step=1e3))
    worst = 0.0
    for _ in range(-(-STACKS // len(ROBOTS))):
        q = arms.posture(rng)
        arms.kinematics.update(q)
        levels: list[Level] = []
        above, before = np.zeros((0, joints)), np.zeros(joints)
        for number in range(rng.integers(2, 7)):
            rows = arms.rows(rng)
            # A hundredth is 60 cm/s or 0.6 rad/s at 60 Hz.
            levels.append(Level(f"level {number}", rows, 0.01 * rng.normal(size=len(rows))))
            step = law.solve(levels, q).displacement
            worst = max(worst, float(np.linalg.norm(above @ (step - before))))
            above, before = np.vstack((above, rows)), step
    assert worst <= 1e-12


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_has_rows_to_stack(name: str, rng: np.random.Generator) -> None:
    arms = Arms(name)
    arms.kinematics.update(arms.posture(rng))
    shapes = {arms.rows(rng).shape for _ in range(100)}
    assert len(shapes) > 3

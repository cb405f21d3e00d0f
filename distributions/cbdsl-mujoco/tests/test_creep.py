"""An object between pads stays where it was gripped."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Surface
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.pose import Pose
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import Library
from cbdsl_mujoco.engine import MujocoEngine
from tests.conftest import ROOT

RATE = 240
# Half of the object's width, and the depth to which each finger is sent into it, m.
HALF, INTO = 0.0225, 0.006


def in_the_hand(engine: MujocoEngine) -> np.ndarray:
    """Return the place of the object in the frame of the hand, m."""
    row = engine.placements[engine.rows["panda_hand"]]
    rotation = row[:9].reshape(3, 3)
    place: np.ndarray = rotation.T @ (engine.pose("cube").position - row[9:])
    return place


def test_cube_between_pads_creeps_less_than_a_tenth_of_a_millimetre_in_ten_seconds(
    library: Library,
) -> None:
    """Without the solver's iterations against slip it creeps 20 mm."""
    path: Path = library.locate(RobotDocument, "panda")
    robot = library.read(path, RobotDocument).document
    model = read_urdf(ROOT / "robots" / robot.model)
    kinematics, positions = Kinematics(robot, model.path), np.zeros(len(Joints(robot).names))
    positions[:-1], positions[-1] = robot.effectors["arm"].postures["ready"], HALF
    kinematics.update(positions)
    hand = kinematics.frame("panda_hand")
    between = hand.position + 0.1034 * hand.rotation[:, 2]
    engine = MujocoEngine(robot, model, 1 / RATE)
    engine.begin(positions)
    cube = SolidShape("box", (HALF, HALF, HALF))
    engine.add(SceneObject("cube", cube, Surface(), 0.1, Pose(between, hand.rotation)))
    target = positions.copy()
    target[-1] -= INTO
    for _ in range(RATE):
        engine.step(target)
    before = in_the_hand(engine)
    assert np.linalg.norm(engine.wrenches()[:, :3], axis=1).min() > 3.0
    for _ in range(10 * RATE):
        engine.step(target)
    assert np.linalg.norm(in_the_hand(engine) - before) < 1e-4

"""The simulated body is the modelled one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio
import pybullet as p
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.articulation import BulletRobot
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf
from tests.backends.conftest import URDF


@pytest.fixture
def client() -> Iterator[int]:
    client = p.connect(p.DIRECT)
    yield client
    p.disconnect(physicsClientId=client)


@pytest.fixture
def body(client: int, dexter: RobotDocument) -> BulletRobot:
    return BulletRobot(client, dexter, read_urdf(URDF), 1 / 240)


@pytest.fixture(scope="module")
def kinematics(dexter: RobotDocument) -> Kinematics:
    return Kinematics(dexter, URDF)


def test_frames_agree_with_pinocchio(body: BulletRobot, dexter: RobotDocument) -> None:
    model = pinocchio.buildModelFromUrdf(str(URDF))
    data = model.createData()
    joints = Joints(dexter)
    columns = [model.joints[model.getJointId(name)].idx_q for name in joints.all]
    lower, upper = model.lowerPositionLimit[columns], model.upperPositionLimit[columns]
    links = {name: number for name, number in body.links.items() if number >= 0}
    rng = np.random.default_rng(0)
    for _ in range(50):
        actuated = rng.uniform(lower, upper)[: len(joints)]
        configuration = np.zeros(model.nq)
        configuration[columns] = joints.expand(actuated)
        pinocchio.framesForwardKinematics(model, data, configuration)
        body.place(actuated)
        placements = body.placements()
        for name, number in links.items():
            frame = data.oMf[model.getFrameId(name, pinocchio.FrameType.BODY)]
            placed = placements[number + 1]
            assert placed[9:] == pytest.approx(frame.translation, abs=1e-6), name
            assert placed[:9] == pytest.approx(frame.rotation.ravel(), abs=1e-6), name


def test_passive_joints_follow_the_measured_angles(
    client: int, body: BulletRobot, dexter: RobotDocument
) -> None:
    joints = Joints(dexter)
    limits = [read_urdf(URDF).joints[name] for name in joints.names]
    targets = np.array([min(max(0.0, limit.lower), limit.upper) for limit in limits])
    body.place(targets)
    flexing = joints.pick([name for name in joints.names if "finger" in name])
    for _ in range(240):
        targets[flexing] += 0.3 / 240
        body.drive(targets)
        p.stepSimulation(physicsClientId=client)
    angles = {
        p.getJointInfo(body.id, index, physicsClientId=client)[1].decode(): p.getJointState(
            body.id, index, physicsClientId=client
        )[0]
        for index in range(p.getNumJoints(body.id, physicsClientId=client))
    }
    for name, coupling in dexter.couplings.items():
        assert angles[name] == pytest.approx(coupling.ratio * angles[coupling.follows], abs=0.006)


def test_links_of_one_group_do_not_touch(
    client: int, body: BulletRobot, kinematics: Kinematics
) -> None:
    rng = np.random.default_rng(0)
    hand = {name for name in body.links if name.startswith("right_finger_")}
    numbers = {body.links[name] for name in hand}
    for _ in range(30):
        body.place(rng.uniform(kinematics.lower, kinematics.upper))
        p.performCollisionDetection(physicsClientId=client)
        pairs = {c[3:5] for c in p.getContactPoints(body.id, body.id, physicsClientId=client)}
        assert not any(set(pair) <= numbers for pair in pairs)


def test_surfaces_have_the_constants_of_the_robot_document(
    client: int, body: BulletRobot, dexter: RobotDocument
) -> None:
    fingers = dexter.simulation.surfaces[0]
    for name in ("left_finger_1_tip", "right_finger_3_proximal"):
        row = p.getDynamicsInfo(body.id, body.links[name], physicsClientId=client)
        assert row[1] == fingers.friction
        assert (row[8], row[9]) == (fingers.damping, fingers.stiffness)


@pytest.mark.parametrize("pattern", ["right_thumb", "right_fingr_*"])
def test_pattern_that_matches_no_link_is_refused(
    client: int, dexter: RobotDocument, pattern: str
) -> None:
    simulation = dexter.simulation.model_copy(update={"no_contact": ((pattern, "right_palm"),)})
    robot = dexter.model_copy(update={"simulation": simulation})
    with pytest.raises(BackendError, match="no link"):
        BulletRobot(client, robot, read_urdf(URDF), 1 / 240)

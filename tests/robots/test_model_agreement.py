"""Links are where independent readers of the model place them, for every type of joint."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import pybullet
import pytest

from cbdsl.backends.bullet.articulation import BulletRobot
from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_mujoco.robot_spec import body_name, make_robot_spec
from tests.robots.small_robot import Hinge, SmallRobot, chain, write_robot

NARROW = '<limit lower="{}" upper="{}" effort="50" velocity="3"/>'
UNNAMED = {
    "includes 0": Hinge(),
    "above 0": Hinge("revolute", NARROW.format(0.6, 2)),
    "below 0": Hinge("prismatic", NARROW.format(-0.4, -0.1)),
    "continuous": Hinge("continuous", ""),
    "fixed with axis 0": Hinge("fixed", ""),
}
MIMICS = {
    "offset": '<mimic joint="j1" multiplier="-2" offset="0.3"/>',
    "chain": '<mimic joint="j2" multiplier="0.5" offset="-0.1"/>',
}


def expected(urdf: Path, given: Mapping[str, float]) -> dict[str, Floats]:
    """Return the placement of each link, shape (4, 4), as Pinocchio has it.

    Args:
        urdf: Model.
        given: Positions of joints by name, rad or m; the others are at 0.
    """
    model = pinocchio.buildModelFromUrdf(str(urdf))
    q = pinocchio.neutral(model)
    for name, value in given.items():
        joint = model.joints[model.getJointId(name)]
        turn = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        q[joint.idx_q : joint.idx_q + joint.nq] = turn
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    links = list(read_urdf(urdf).links)
    frames = {name: model.getFrameId(name, pinocchio.FrameType.BODY) for name in links}
    return {name: data.oMf[frame].homogeneous for name, frame in frames.items()}


def by_kinematics(small: SmallRobot, posture: Floats) -> dict[str, Floats]:
    kinematics = small.kinematics()
    kinematics.update(posture)
    frames = {link: kinematics.frame(link) for link in read_urdf(small.urdf).links}
    return {link: placement(f.rotation, f.position) for link, f in frames.items()}


def by_tree(small: SmallRobot, posture: Floats) -> dict[str, Floats]:
    joints = small.kinematics().joints
    tree = LinkTree(read_urdf(small.urdf), joints, small.document.base)
    tree.update(posture)
    poses = {link: tree.pose(link) for link in tree.rows}
    return {link: placement(pose.rotation, pose.position) for link, pose in poses.items()}


def by_interpreter(small: SmallRobot, posture: Floats) -> dict[str, Floats]:
    model, joints = read_urdf(small.urdf), small.kinematics().joints
    positions = zip(joints.all, joints.expand(posture).tolist(), strict=True)
    base = small.document.base
    placed = JointTree(model.beyond(base)).place({**model.rests, **dict(positions)})
    poses = {link: joint.child for link, joint in placed.items()}
    frames = {link: placement(pose.rotation, pose.position) for link, pose in poses.items()}
    return {base: np.eye(4)} | frames


def by_mujoco(small: SmallRobot, posture: Floats) -> dict[str, Floats]:
    model, joints = read_urdf(small.urdf), small.kinematics().joints
    compiled = make_robot_spec(small.document, model, 0.004).compile()
    data = mujoco.MjData(compiled)
    rows = [int(compiled.joint(name).qposadr[0]) for name in joints.all]
    data.qpos[rows] = joints.expand(posture)
    mujoco.mj_forward(compiled, data)
    bodies = {link: data.body(body_name(link)) for link in model.links}
    return {link: placement(b.xmat.reshape(3, 3), b.xpos) for link, b in bodies.items()}


def by_bullet(small: SmallRobot, posture: Floats) -> dict[str, Floats]:
    """Place the robot and let a second pass, so that servos settle at their references."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        robot = BulletRobot(client, small.document, read_urdf(small.urdf), 1 / 240)
        robot.place(posture)
        for _ in range(240):
            robot.drive(posture)
            pybullet.stepSimulation(physicsClientId=client)
        rows = robot.placements()
        return {
            link: placement(rows[number + 1, :9].reshape(3, 3), rows[number + 1, 9:])
            for link, number in robot.links.items()
        }
    finally:
        pybullet.disconnect(client)


def placement(rotation: Floats, position: Floats) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, position
    return matrix


READERS = {
    "kinematics": by_kinematics,
    "tree": by_tree,
    "interpreter": by_interpreter,
    "mujoco": by_mujoco,
    "bullet": by_bullet,
}
# A servo of an engine holds its joint so near its reference.
TOLERANCES = {"bullet": 1e-3}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(("kind", "mimic"), [*product(UNNAMED, MIMICS)])
def test_links_of_all_readers_agree_with_pinocchio(
    reader: str, kind: str, mimic: str, tmp_path: Path
) -> None:
    unnamed, tolerance = UNNAMED[kind], TOLERANCES.get(reader, 1e-9)
    follower = Hinge("revolute", NARROW.format(-9, 9) + MIMICS["offset"])
    second = Hinge("revolute", NARROW.format(-9, 9) + MIMICS[mimic])
    text = chain(Hinge(), follower, unnamed, second)
    if kind.startswith("fixed"):
        text = text.replace('<axis xyz="0 0 1"/></joint>', '<axis xyz="0 0 0"/></joint>')
    ratio, offset = {"offset": (-2, 0.3), "chain": (-1, 0.05)}[mimic]
    small = write_robot(
        tmp_path,
        text,
        "effectors: {arm: {joints: [j1]}}\ncouplings:\n"
        "  j2: {follows: j1, ratio: -2, offset: 0.3}\n"
        f"  j4: {{follows: j1, ratio: {ratio}, offset: {offset}}}",
    )
    rest = {"above 0": 0.6, "below 0": -0.1}.get(kind, 0.0)
    for position in (-0.7, 0.0, 0.4):
        given = {"j1": position, "j2": -2 * position + 0.3, "j4": ratio * position + offset}
        if rest:
            given["j3"] = rest
        reached = READERS[reader](small, np.array([position]))
        for link, frame in expected(small.urdf, given).items():
            assert reached[link] == pytest.approx(frame, abs=tolerance), link

"""The simulated body is the modelled one."""

from __future__ import annotations

import mujoco as mj
import numpy as np
import pinocchio
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_mujoco.backend import MujocoBackend
from cbdsl_mujoco.robot_spec import body_name, compile_spec, make_robot_spec
from tests.backends.conftest import URDF, made_stage


def test_frames_agree_with_pinocchio(blind: MujocoBackend, dexter: RobotDocument) -> None:
    model = pinocchio.buildModelFromUrdf(str(URDF))
    data = model.createData()
    joints = Joints(dexter)
    columns = [model.joints[model.getJointId(name)].idx_q for name in joints.all]
    lower, upper = model.lowerPositionLimit[columns], model.upperPositionLimit[columns]
    rng = np.random.default_rng(0)
    for _ in range(50):
        actuated = rng.uniform(lower, upper)[: len(joints)]
        configuration = np.zeros(model.nq)
        configuration[columns] = joints.expand(actuated)
        pinocchio.framesForwardKinematics(model, data, configuration)
        blind.truth.begin(actuated)
        assert set(blind.truth.rows) == set(read_urdf(URDF).links)
        for name in blind.truth.rows:
            frame = data.oMf[model.getFrameId(name, pinocchio.FrameType.BODY)]
            pose = blind.truth.link_pose(name)
            assert pose.position == pytest.approx(frame.translation, abs=1e-12), name
            assert pose.rotation == pytest.approx(frame.rotation, abs=1e-12), name


def test_masses_and_inertias_are_those_of_the_urdf(dexter: RobotDocument) -> None:
    model = pinocchio.buildModelFromUrdf(str(URDF))
    compiled = compile_spec(make_robot_spec(dexter, read_urdf(URDF), 1 / 240), read_urdf(URDF))
    data, own = model.createData(), mj.MjData(compiled)
    joints = Joints(dexter)
    columns = [model.joints[model.getJointId(name)].idx_v for name in joints.all]
    rows = [int(compiled.joint(name).dofadr[0]) for name in joints.all]
    mj.mj_forward(compiled, own)
    inertia = np.zeros((compiled.nv, compiled.nv))
    mj.mj_fullM(compiled, own, inertia)
    expected = pinocchio.crba(model, data, np.zeros(model.nq))
    upper = np.triu(expected) + np.triu(expected, 1).T
    # Links without mass are given a tenth of a gram.
    assert inertia[np.ix_(rows, rows)] == pytest.approx(upper[np.ix_(columns, columns)], abs=2e-3)


def test_coupled_joints_follow(blind: MujocoBackend, dexter: RobotDocument) -> None:
    joints = Joints(dexter)
    flexing = joints.pick([name for name in joints.names if "finger" in name])
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    reference = blind.observe().positions
    for _ in range(60):
        reference[flexing] += 0.3 / 60
        blind.apply(reference)
        blind.step()
    positions = dict(zip(joints.all, blind.truth.all_positions().tolist(), strict=True))
    for name, coupling in dexter.couplings.items():
        expected = coupling.ratio * positions[coupling.follows]
        assert positions[name] == pytest.approx(expected, abs=0.002), name


def test_servos_bear_gravity_within_the_allowed_error(blind: MujocoBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    before = blind.observe().positions
    for _ in range(60):
        blind.step()
    assert blind.observe().positions == pytest.approx(before, abs=1e-3)
    assert np.abs(blind.truth.efforts()).max() > 5.0, "and its torque is that of the servos"


@pytest.mark.parametrize("pattern", ["right_thumb", "right_fingr_*"])
def test_pattern_that_matches_no_link_is_refused(dexter: RobotDocument, pattern: str) -> None:
    simulation = dexter.simulation.model_copy(update={"no_contact": ((pattern, "right_palm"),)})
    robot = dexter.model_copy(update={"simulation": simulation})
    with pytest.raises(BackendError, match="no link"):
        make_robot_spec(robot, read_urdf(URDF), 1 / 240)


def test_model_that_cannot_be_simulated_says_why(dexter: RobotDocument) -> None:
    spec = make_robot_spec(dexter, read_urdf(URDF), 1 / 240)
    spec.add_exclude(bodyname1=body_name(dexter.base), bodyname2="nobody")
    with pytest.raises(BackendError, match=r"cannot read the model .*dexter\.urdf.*nobody"):
        compile_spec(spec, read_urdf(URDF))

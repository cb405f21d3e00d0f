"""Proposed postures: within limits, away from singular ones, clear of the ground and themselves."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from cbdsl.kinematics.ready_posture import ReadyPosture
from cbdsl.robot.chains import Chain, chains
from cbdsl.robot.link_place import at_first, link_frame
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.robot.weight import weights
from tests.robot.test_chains import MODELS

ARMS = ("kuka_iiwa/model.urdf", "franka_panda/panda.urdf", "xarm6_robot.urdf", "sixaxis.urdf")
LEGS = ("a1.urdf", "laikago_toes_zup.urdf", "aliengo.urdf")


def _model(name: str) -> UrdfModel:
    return read_urdf(next(path for path in MODELS if str(path).endswith(name)))


def _kinematics(path: Path, chain: Chain, positions: tuple[float, ...]) -> tuple[object, object]:
    """Return the tip's position and Jacobian over the chain's joints, by another library."""
    model = pinocchio.buildModelFromUrdf(str(path))
    data, configuration = model.createData(), pinocchio.neutral(model)
    at = dict(zip(chain.joints, positions, strict=True))
    for joint in read_urdf(path).joints.values():
        if joint.movable:
            index = model.joints[model.getJointId(joint.name)]
            value = next((p for each, p in at.items() if each.name == joint.name), at_first(joint))
            turn = [math.cos(value), math.sin(value)] if index.nq == 2 else [value]
            configuration[index.idx_q : index.idx_q + index.nq] = turn
    pinocchio.computeJointJacobians(model, data, configuration)
    pinocchio.updateFramePlacements(model, data)
    frame = model.getFrameId(chain.tip)
    jacobian = pinocchio.getFrameJacobian(
        model, data, frame, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    )
    columns = [model.joints[model.getJointId(joint.name)].idx_v for joint in chain.joints]
    return data.oMf[frame].translation, jacobian[:, columns]


@pytest.mark.parametrize("name", [*ARMS, *LEGS])
def test_tip_position_agrees_with_pinocchio(name: str) -> None:
    model = _model(name)
    for chain in (each for each in chains(model) if each.tip):
        row = ReadyPosture(model, chain.joints, chain.tip)
        positions = row.find()
        place, _ = _kinematics(model.path, chain, positions)
        first = {joint.name: at_first(joint) for joint in model.joints.values() if joint.movable}
        given = dict(zip((joint.name for joint in chain.joints), positions, strict=True))
        at = link_frame(model, first | given, chain.tip)[1]
        assert np.allclose(at, place, atol=1e-9), chain.name


@pytest.mark.parametrize("name", [*ARMS, *LEGS])
def test_limb_can_move_its_tip_every_way(name: str) -> None:
    model = _model(name)
    for chain in (each for each in chains(model) if len(each.joints) >= 3):
        row = ReadyPosture(model, chain.joints, chain.tip)
        positions = row.find()
        _, jacobian = _kinematics(model.path, chain, positions)
        along = np.asarray(jacobian)[:3] / row.length
        smallest = np.linalg.svd(along, compute_uv=False)[-1]
        assert smallest > 0.05, (chain.name, positions)
        if len(chain.joints) >= 6:
            both = np.vstack([along, np.asarray(jacobian)[3:]])
            assert np.linalg.svd(both, compute_uv=False)[-1] > 0.05, (chain.name, positions)


@pytest.mark.parametrize("name", ARMS)
def test_posture_of_an_arm_on_its_base_stays_above_the_base(name: str) -> None:
    model = _model(name)
    chain = chains(model)[0]
    row = ReadyPosture(model, chain.joints, chain.tip)
    place, _ = _kinematics(model.path, chain, row.find())
    assert place[2] > 0.1 * row.length


def test_positions_keep_from_limits() -> None:
    for path in MODELS:
        model = read_urdf(path)
        for chain in (each for each in chains(model) if each.tip):
            positions = ReadyPosture(model, chain.joints, chain.tip).find()
            for joint, position in zip(chain.joints, positions, strict=True):
                margin = 0.05 * (joint.upper - joint.lower)
                inside = joint.lower + margin <= position <= joint.upper - margin
                assert inside or joint.endless, (path, joint.name, position)


@pytest.mark.parametrize("effort", [5.0, 20.0, 60.0])
def test_ready_posture_of_weak_joints_is_one_that_their_efforts_hold(effort: float) -> None:
    model = _model("kuka_iiwa/model.urdf")
    (chain,) = chains(model)
    weak = [joint._replace(effort=effort) for joint in chain.joints]
    row = ReadyPosture(model, weak, chain.tip)
    positions = row.find()
    assert row.can_hold(positions) and row.is_clear(positions)
    needs = weights(model, dict(zip((joint.name for joint in weak), positions, strict=True)))
    assert max(map(abs, needs.values())) <= effort
    unbounded = ReadyPosture(model, chain.joints, chain.tip).find()
    assert (positions == unbounded) == (effort == 60.0)

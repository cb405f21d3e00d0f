"""Torques with which joints bear the links of public models, beside those of Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.robot.weight import overloads, weights
from tests.robot.test_chains import read

NAMES = ("kuka_iiwa/model.urdf", "franka_panda/panda.urdf", "xarm6_robot.urdf")


@pytest.mark.parametrize("name", NAMES)
@given(seed=st.integers(0, 1000))
def test_weights_of_public_models_agree_with_pinocchio(name: str, seed: int) -> None:
    model = read(name)
    pin = pinocchio.buildModelFromUrdf(str(model.path))
    positions = np.random.default_rng(seed).uniform(-1.0, 1.0, pin.nq)
    expected = pinocchio.computeGeneralizedGravity(pin, pin.createData(), positions)
    names = list(pin.names)[1:]
    borne = weights(model, dict(zip(names, positions.tolist(), strict=True)))
    assert [borne[each] for each in names] == pytest.approx(expected.tolist(), abs=1e-6)


def test_weights_above_a_link_are_those_of_the_whole_model() -> None:
    model = read("franka_panda/panda.urdf")
    positions = {"panda_joint2": 0.5, "panda_joint4": -1.5, "panda_finger_joint1": 0.03}
    whole, part = weights(model, positions), weights(model, positions, "panda_link3")
    assert part == pytest.approx({name: whole[name] for name in part})
    assert "panda_joint4" in part
    assert "panda_joint2" not in part


def test_overloads_are_the_joints_that_need_more_than_their_effort() -> None:
    model = read("kuka_iiwa/model.urdf")
    stretched = {"lbr_iiwa_joint_2": np.pi / 2}
    need = abs(weights(model, stretched)["lbr_iiwa_joint_2"])
    for most, found in (
        (need * 1.01, {}),
        (need * 0.99, {"lbr_iiwa_joint_2": (need, need * 0.99)}),
    ):
        assert overloads(model, stretched, {"lbr_iiwa_joint_2": most}) == found

"""Fingertips are as soft as the robot file says, on every kind of object."""

from __future__ import annotations

import mujoco as mj
import numpy as np
import pytest

from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Surface
from cbdsl.kinematics.pose import Pose
from cbdsl_mujoco.backend import MujocoBackend
from tests.backends.conftest import URDF, made_stage, sightless

TIP = "right_finger_3_tip"


def stiffness_felt(backend: MujocoBackend, mass: float) -> float:
    """Return force over depth, N/m, of a fingertip in a block that is held 4 mm inside it."""
    backend.reset(made_stage({}), None, np.random.default_rng(0))
    engine = backend.truth
    normal = np.array([0.0, 0.0, -1.0])
    tip = engine.link_pose(TIP)
    radius = float(engine._world.bare.geom(f"{TIP}/0").size[0])
    half = 0.05
    place = Pose(tip.position + (radius - 0.004 + half) * normal, np.eye(3))
    block = SolidShape("box", (half, half, half))
    engine.add(SceneObject("block", block, Surface(), mass, place))
    if mass:
        engine.attach("block")
    targets = engine.read()[0]
    for _ in range(120):
        engine.step(targets)
    model, data = engine._world.model, engine._world.data
    force, number = np.zeros(6), model.geom(f"{TIP}/0").id
    for index in range(data.ncon):
        contact = data.contact[index]
        if number in contact.geom:
            mj.mj_contactForce(model, data, index, force)
            assert force[0] > 1.0
            return float(force[0] / -contact.dist)
    raise AssertionError("the fingertip touches nothing")


@pytest.mark.parametrize("mass", [0.0, 0.3])
@pytest.mark.parametrize("stiffness", [3000.0, 6000.0])
def test_fingertip_gives_way_by_its_stiffness(
    dexter: RobotDocument, stiffness: float, mass: float
) -> None:
    first, *others = dexter.simulation.surfaces
    soft = first.model_copy(update={"stiffness": stiffness, "damping": stiffness / 50})
    simulation = dexter.simulation.model_copy(update={"surfaces": (soft, *others)})
    backend = MujocoBackend(sightless(dexter.model_copy(update={"simulation": simulation})), URDF)
    assert stiffness_felt(backend, mass) == pytest.approx(stiffness, rel=0.35)
    backend.close()


def test_rigid_fingertip_hardly_gives_way(dexter: RobotDocument) -> None:
    first, *others = dexter.simulation.surfaces
    rigid = first.model_copy(update={"stiffness": None, "damping": None})
    simulation = dexter.simulation.model_copy(update={"surfaces": (rigid, *others)})
    backend = MujocoBackend(sightless(dexter.model_copy(update={"simulation": simulation})), URDF)
    assert stiffness_felt(backend, 0.0) > 10_000
    backend.close()


def test_removing_an_object_removes_its_contact_pairs(blind: MujocoBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    engine = blind.truth
    place = Pose(np.array([0.5, 0.0, 0.0]), np.eye(3))
    engine.add(SceneObject("ball", SolidShape.ball(0.05), Surface(), 0.2, place))
    assert engine._world.model.npair > 0
    engine.remove("ball")
    blind.step()
    assert engine._world.model.npair == 0

"""A robot with a gripper whose fingers slide, by documents alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cbdsl
from cbdsl.backends.simulated_backend import simulate
from cbdsl.checking.program import check_program
from cbdsl.checking.stage.fitted_stage import fitted_stage
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.episode import Runner
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

URDF = ROOT / "robots" / "panda.urdf"


@pytest.fixture(scope="module")
def panda(library: Library) -> RobotDocument:
    return library.read(library.locate(RobotDocument, "panda"), RobotDocument).document


def test_both_forward_kinematics_slide_the_fingers(panda: RobotDocument) -> None:
    kinematics, model = Kinematics(panda, URDF), read_urdf(URDF)
    tree = LinkTree(model, Joints(panda), panda.base)
    rng = np.random.default_rng(0)
    for _ in range(20):
        posture = rng.uniform(kinematics.lower, kinematics.upper)
        kinematics.update(posture)
        tree.update(posture)
        for link in ("panda_hand", "panda_leftfinger_pad", "panda_rightfinger_pad"):
            frame = kinematics.frame(link)
            assert tree.pose(link).position == pytest.approx(frame.position, abs=1e-12)
            assert tree.pose(link).rotation == pytest.approx(frame.rotation, abs=1e-12)
        left, right = (tree.pose(f"panda_{side}finger_pad").position for side in ("left", "right"))
        assert np.linalg.norm(left - right) == pytest.approx(2 * posture[-1])


def test_joint_without_end_has_no_limits(tmp_path: Path, panda: RobotDocument) -> None:
    file = tmp_path / "endless.urdf"
    text = URDF.read_text().replace(
        '<joint name="panda_joint1" type="revolute">',
        '<joint name="panda_joint1" type="continuous">',
    )
    file.write_text(text)
    kinematics = Kinematics(panda, file)
    assert (kinematics.lower[0], kinematics.upper[0]) == (-np.inf, np.inf)
    assert kinematics.lower[1:] == pytest.approx(Kinematics(panda, URDF).lower[1:])
    turned = np.zeros(len(kinematics.joints))
    kinematics.update(turned)
    before = kinematics.frame("panda_hand").rotation
    kinematics.update(turned + np.eye(len(turned))[0] * 4 * np.pi)
    assert kinematics.frame("panda_hand").rotation == pytest.approx(before, abs=1e-12)


def test_policy_of_reachtouch_closes_pads_on_a_box(panda: RobotDocument) -> None:
    request = cbdsl.load("reachtouch", values={"robot": "panda"})
    with cbdsl.simulate(request, backend="kinematic", cameras="ideal") as world:
        # Pads inside of the ball around a box are not yet closed on air.
        results = [world.robot.run(seed) for seed in (1, 2)]
    assert [each.rewarded for each in results] == [True, True]
    assert not any(state.startswith("X--") for each in results for state in each.predicates)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_pick_puts_a_cube_of_a_panda_at_its_place(
    panda: RobotDocument, library: Library, engine: str
) -> None:
    program = check_program("pick", {"robot": "panda"}, library)
    loaded = library.read(library.locate(StageDocument, program.stage), StageDocument)
    stage = fitted_stage(loaded, panda, ROOT / "robots" / "panda.yaml")
    backend = simulate(engine, panda, URDF, cameras="ideal")
    Runner(panda, Kinematics(panda, URDF), program, backend).run(stage, 1)
    cube = backend.truth.pose("cube")
    assert cube.position == pytest.approx([0.49, 0.294, 0.0226], abs=0.02)
    backend.close()

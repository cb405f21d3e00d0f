"""Poses and Jacobians of links, against finite differences and Pinocchio."""

import re
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from cbdsl.documents.calibration import with_corrections
from cbdsl.documents.robot import Correction, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.urdf import UrdfError

LINKS = ["right_palm", "left_palm", "left_camera", "right_finger_1_tip", "left_finger_2_tip"]
STEP = 1e-6


def test_dexter_has_24_actuated_joints_in_five_synergies(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    assert len(kinematics.joints) == 24
    assert [len(effector.joints) for effector in dexter.effectors.values()] == [2, 7, 7, 4, 4]
    assert (kinematics.lower < kinematics.upper).all()


@pytest.mark.parametrize("link", LINKS)
def test_jacobians_by_finite_differences(
    kinematics: Kinematics, posture: np.ndarray, link: str
) -> None:
    kinematics.update(posture)
    jacobian, frame = kinematics.jacobian(link).copy(), kinematics.frame(link)
    for column in range(len(posture)):
        kinematics.update(posture + STEP * np.eye(len(posture))[column])
        moved = kinematics.frame(link)
        linear = (moved.position - frame.position) / STEP
        turn = (moved.rotation @ frame.rotation.T - np.eye(3)) / STEP
        angular = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
        assert jacobian[:, column] == pytest.approx(np.r_[linear, angular], abs=1e-4)


@pytest.mark.parametrize("link", LINKS)
def test_links_and_jacobians_agree_with_pinocchio(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, posture: np.ndarray, link: str
) -> None:
    model = pinocchio.buildModelFromUrdf(str(urdf))
    data, joints = model.createData(), kinematics.joints
    expansion = np.zeros((model.nv, len(joints)))
    places = [model.joints[model.getJointId(name)].idx_v for name in joints.all]
    expansion[places] = joints.expansion
    pinocchio.forwardKinematics(model, data, expansion @ posture)
    pinocchio.updateFramePlacements(model, data)
    number = model.getFrameId(link, pinocchio.FrameType.BODY)
    world = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    jacobian = pinocchio.computeFrameJacobian(model, data, expansion @ posture, number, world)
    kinematics.update(posture)
    frame = kinematics.frame(link)
    assert frame.position == pytest.approx(data.oMf[number].translation, abs=1e-14)
    assert frame.rotation == pytest.approx(data.oMf[number].rotation, abs=1e-14)
    assert kinematics.jacobian(link) == pytest.approx(jacobian @ expansion, abs=1e-14)


def test_sliding_joint_moves_its_link_along_the_axis(
    dexter: RobotDocument, urdf: Path, tmp_path: Path
) -> None:
    model = tmp_path / "sliding.urdf"
    text = urdf.read_text("utf-8")
    before = re.search(r'<joint name="right_arm_3" type="revolute">', text)
    assert before is not None
    model.write_text(text.replace(before[0], before[0].replace("revolute", "prismatic")), "utf-8")
    sliding = Kinematics(dexter, model)
    column = sliding.joints.index["right_arm_3"]
    posture = np.full(len(sliding.lower), 0.3)
    sliding.update(posture)
    point, origin = sliding.point("right_palm", (0.1, 0.2, 0.3)), sliding.frame("right_palm")
    posture[column] += 0.25
    sliding.update(posture)
    moved = sliding.frame("right_palm")
    assert moved.rotation == pytest.approx(origin.rotation)
    assert moved.position - origin.position == pytest.approx(0.25 * point.jacobian[:3, column])
    assert not point.jacobian[3:, column].any()


def test_resting_and_unused_limbs_have_their_usual_poses(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, posture: np.ndarray
) -> None:
    rng = np.random.default_rng(0)
    for _ in range(40):
        moved = kinematics.joints.of(rng.choice(list(dexter.effectors)))
        posture = posture.copy()
        posture[moved] += rng.normal(0.0, 0.1, len(moved)) * rng.integers(2)
        kinematics.update(posture)
        link = rng.choice(LINKS)
        anew = Kinematics(dexter, urdf)
        anew.update(posture)
        assert (kinematics.frame(link).rotation == anew.frame(link).rotation).all()
        for found, wanted in zip(
            kinematics.point(link, (0.1, 0, 0)), anew.point(link, (0.1, 0, 0)), strict=True
        ):
            assert (found == wanted).all()


@pytest.mark.parametrize("link", LINKS)
def test_every_point_of_a_link_turns_as_the_link(
    kinematics: Kinematics, posture: np.ndarray, link: str
) -> None:
    kinematics.update(posture)
    angular = kinematics.jacobian(link)[3:]
    for offset in ((0.0, 0.0, 0.0), (0.1, -0.2, 0.3)):
        kinematics.update(posture)
        assert np.array_equal(kinematics.point(link, offset).jacobian[3:], angular)
        assert np.array_equal(kinematics.turning(link), angular)


@pytest.mark.parametrize("link", LINKS)
def test_link_turns_in_its_own_axes_as_in_the_world(
    kinematics: Kinematics, posture: np.ndarray, link: str
) -> None:
    kinematics.update(posture)
    own = kinematics.frame(link).rotation.T @ kinematics.turning(link)
    assert own.any()
    assert kinematics.own_turning(link) == pytest.approx(own, abs=1e-12)


def test_links_are_placed_together_as_one_by_one(
    kinematics: Kinematics, posture: np.ndarray
) -> None:
    links = tuple(LINKS)
    first = kinematics.placed(links)
    kinematics.update(posture)
    for link, before, placed in zip(links, first, kinematics.placed(links), strict=True):
        frame = kinematics.frame(link)
        assert np.array_equal(placed.position, frame.position)
        assert np.array_equal(placed.rotation, frame.rotation)
        assert not np.array_equal(before.position, frame.position), "it stays as it was"


def test_update_copies_its_posture(kinematics: Kinematics, posture: np.ndarray) -> None:
    kinematics.update(posture)
    before = kinematics.frame(LINKS[0]).position
    given = posture.copy()
    kinematics.update(given)
    given += 0.1
    assert np.array_equal(kinematics.frame(LINKS[0]).position, before)
    kinematics.update(given)
    assert not np.allclose(kinematics.frame(LINKS[0]).position, before)


def test_origins_agree_with_the_frames_of_links(
    kinematics: Kinematics, posture: np.ndarray
) -> None:
    """Joints are at the origins of the links that they turn."""
    for change in (0.0, 0.1):
        kinematics.update(posture + change)
        *joints, first, second = kinematics.origins(("right_arm_3",), tuple(LINKS[:2]))
        assert np.array_equal(joints, [kinematics.frame("right_link_3").position])
        for link, origin in zip(LINKS[:2], (first, second), strict=True):
            assert np.array_equal(origin, kinematics.frame(link).position)
    assert kinematics.origins((), ()).shape == (0, 3)


def test_unnamed_joint_stays_at_zero(
    dexter: RobotDocument, urdf: Path, kinematics: Kinematics, posture: np.ndarray, tmp_path: Path
) -> None:
    wheel = (
        '<link name="wheel"/><joint name="axle" type="continuous"><parent link="torso"/>'
        '<child link="wheel"/><axis xyz="0 0 1"/></joint></robot>'
    )
    model = tmp_path / "wheeled.urdf"
    model.write_text(urdf.read_text("utf-8").replace("</robot>", wheel), encoding="utf-8")
    wheeled = Kinematics(dexter, model)
    assert np.array_equal(wheeled.lower, kinematics.lower)
    wheeled.update(posture)
    kinematics.update(posture)
    for link in LINKS:
        assert wheeled.frame(link).position == pytest.approx(kinematics.frame(link).position)
        assert wheeled.jacobian(link) == pytest.approx(kinematics.jacobian(link))


def test_passive_joints_follow(kinematics: Kinematics, posture: np.ndarray) -> None:
    joints = kinematics.joints
    every = joints.expand(posture)
    proximal, distal = joints.pick(["right_finger_2", "right_finger_2_distal"])
    spread, other = joints.pick(["left_spread", "left_spread_2"])
    assert every[distal] == pytest.approx(every[proximal] / 3, rel=1e-6)
    assert every[other] == every[spread]


def test_arms_mirror_each_other(dexter: RobotDocument, kinematics: Kinematics) -> None:
    posture = np.zeros(len(kinematics.joints))
    for arm in ("left_arm", "right_arm"):
        posture[kinematics.joints.of(arm)] = dexter.effectors[arm].postures["home"]
    kinematics.update(posture)
    left, right = (kinematics.frame(f"{side}_palm").position for side in ("left", "right"))
    assert left == pytest.approx(right * [1, -1, 1], abs=1e-3)


def test_unknown_link_is_named(kinematics: Kinematics) -> None:
    with pytest.raises(KeyError, match="no_such_link"):
        kinematics.frame("no_such_link")


def test_model_that_cannot_be_read_says_so(dexter: RobotDocument, tmp_path: Path) -> None:
    (tmp_path / "no.urdf").write_text("<robot name='no'><joint/></robot>", encoding="utf-8")
    with pytest.raises(UrdfError, match=r"no\.urdf"):
        Kinematics(dexter, tmp_path / "no.urdf")


def test_correction_displaces_the_camera_and_nothing_else(
    dexter: RobotDocument, kinematics: Kinematics, urdf: Path
) -> None:
    own = Correction(position=(0.01, -0.02, 0.03), rotation=(0.0, 0.0, 0.1))
    corrected = Kinematics(with_corrections(dexter, {"left": own}), urdf)
    posture = np.linspace(0.1, 0.6, len(kinematics.joints))
    kinematics.update(posture)
    corrected.update(posture)
    model, found = kinematics.frame("left_camera"), corrected.frame("left_camera")
    assert model.rotation.T @ (found.position - model.position) == pytest.approx(own.position)
    assert (model.rotation.T @ found.rotation)[:2, 0] == pytest.approx((np.cos(0.1), np.sin(0.1)))
    right = kinematics.frame("right_camera"), corrected.frame("right_camera")
    assert right[0].position == pytest.approx(right[1].position)
    assert right[0].rotation == pytest.approx(right[1].rotation)


def test_query_of_another_posture_keeps_the_current_one(dexter: RobotDocument, urdf: Path) -> None:
    """Keep it after requests in between, also after requests for a new link."""
    rng = np.random.default_rng(5)
    kinematics, alone = Kinematics(dexter, urdf), Kinematics(dexter, urdf)
    links = ["left_camera", "right_palm", "right_finger_1_tip", "left_palm"]
    newest, another = rng.uniform(-1, 1, (2, len(kinematics.joints)))
    kinematics.update(newest)
    for known, link in enumerate(links):
        kinematics.frame(links[0])
        there = kinematics.posed(another, lambda link=link: kinematics.frame(link))  # type: ignore[misc]
        alone.update(another)
        np.testing.assert_array_equal(there.position, alone.frame(link).position)
        np.testing.assert_array_equal(there.rotation, alone.frame(link).rotation)
        alone.update(newest)
        for each in links[: known + 1]:
            np.testing.assert_array_equal(
                kinematics.frame(each).position, alone.frame(each).position
            )
    np.testing.assert_array_equal(kinematics.positions, newest)

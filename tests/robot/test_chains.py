"""Chains of actuated joints, in the models that PyBullet and this package ship."""

from __future__ import annotations

import sys
from pathlib import Path

import pybullet_data
import pytest

from cbdsl.robot.chains import chains, root
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.urdf_reader import parse_urdf, read_urdf
from cbdsl.yaml_text.library import shipped


def readable_models() -> list[Path]:
    found = []
    folders = (Path(pybullet_data.getDataPath()), shipped() / "robots")
    for path in sorted(file for folder in folders for file in folder.rglob("*.urdf")):
        try:
            model = read_urdf(path)
        except UrdfError:
            continue
        if chains(model):
            found.append(path)
    return found


MODELS = readable_models()


def read(name: str) -> UrdfModel:
    return read_urdf(next(path for path in MODELS if str(path).endswith(name)))


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_chains_are_disjoint_rows_of_movable_joints(path: Path) -> None:
    model = read_urdf(path)
    found = chains(model)
    joints = [joint.name for chain in found for joint in chain.joints]
    assert len(set(joints)) == len(joints) and set(joints) <= set(model.movable)
    assert len({chain.name for chain in found}) == len(found)
    for chain in found:
        if chain.tip is None:
            continue  # the fingers of a hand
        row = [joint.name for joint in chain.joints]
        above = list(model.above(chain.tip))
        assert list(reversed(above))[-len(row) :] == row
    assert root(model) not in {joint.child for joint in model.joints.values()}


def test_every_joint_that_is_actuated_is_in_a_chain() -> None:
    for path in MODELS:
        model = read_urdf(path)
        mimics = {joint.name for joint in model.joints.values() if joint.mimic}
        empty = {joint.name for joint in model.joints.values() if joint.lower > joint.upper}
        open_ended = {j.name for j in model.joints.values() if not (j.limited or j.endless)}
        joints = {joint.name for chain in chains(model) for joint in chain.joints}
        assert joints == set(model.movable) - mimics - empty - open_ended, path


@pytest.mark.parametrize(
    ("name", "arm", "tip"),
    [
        ("kuka_iiwa/model.urdf", "arm", "lbr_iiwa_link_7"),
        ("franka_panda/panda.urdf", "arm", "panda_grasptarget"),
    ],
)
def test_tip_of_an_arm_is_the_frame_of_its_tool(name: str, arm: str, tip: str) -> None:
    first = chains(read(name))[0]
    assert (first.name, len(first.joints), first.tip) == (arm, 7, tip)


def test_legs_are_named_by_the_common_part_of_their_joints() -> None:
    legs = chains(read("a1.urdf"))
    assert {leg.name: len(leg.joints) for leg in legs} == dict.fromkeys(("FR", "FL", "RR", "RL"), 3)


def test_joints_that_follow_others_are_not_actuated() -> None:
    model = read("xarm6_with_gripper.urdf")
    gripper = chains(model)[-1]
    assert [joint.name for joint in gripper.joints] == ["drive_joint"]
    followers = [joint.mimic.joint for joint in model.joints.values() if joint.mimic]
    assert set(followers) == {"drive_joint"}


def row(*names: tuple[str, str]) -> UrdfModel:
    """Return a model of joints in a row, each given by its name and the link that it moves."""
    links = ["base", *(link for _, link in names)]
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    joints = [
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{link}"/>'
        f'<axis xyz="0 0 1"/>{limit}</joint>'
        for parent, (name, link) in zip(links, names, strict=False)
    ]
    text = "".join(f'<link name="{link}"/>' for link in links) + "".join(joints)
    return parse_urdf(f'<robot name="row">{text}</robot>', Path("row.urdf"))


ARM = [(f"joint{i}", f"link{i}") for i in range(1, 6)]


@pytest.mark.parametrize(
    "last",
    [
        ("gripper", "moving_jaw_so101_v1_link"),
        ("jointGripper", "gripperMover"),
        ("joint6", "left_finger"),
        ("gripper_left_joint", "gripper_left_motor_double_link"),
    ],
)
def test_chains_part_before_the_joint_of_a_gripper(last: tuple[str, str]) -> None:
    found = {each.name: each for each in chains(row(*ARM, last))}
    assert [*found] == ["arm", "hand"]
    assert [joint.name for joint in found["arm"].joints] == [name for name, _ in ARM]
    assert found["arm"].tip == "link5"
    assert [joint.name for joint in found["hand"].joints] == [last[0]]


@pytest.mark.parametrize(
    "last", [("wrist_roll", "gripper_link"), ("GripperYaw", "palm"), ("joint6", "gripper_base")]
)
def test_chains_keep_a_joint_that_turns_a_gripper(last: tuple[str, str]) -> None:
    (found,) = chains(row(*ARM, last))
    assert (found.name, len(found.joints)) == ("arm", 6)


def test_chains_of_a_gripper_alone_stay_whole() -> None:
    (found,) = chains(row(("left_finger_1", "a"), ("left_finger_2", "b")))
    assert len(found.joints) == 2


def limbs(*rows: tuple[str, str, int]) -> UrdfModel:
    """Return a model with rows of joints, each given by its root, the joints' format and number."""
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    links, joints = ['<link name="base"/>'], []
    for parent, name, count in rows:
        for i in range(count):
            link = name.format(i) + "_link"
            links.append(f'<link name="{link}"/>')
            joints.append(
                f'<joint name="{name.format(i)}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{link}"/>{limit}</joint>'
            )
            parent = link
    return parse_urdf(f'<robot name="r">{"".join(links + joints)}</robot>', Path("r.urdf"))


@pytest.mark.parametrize(
    ("left", "right", "kind"),
    [
        ("arm_left_{}_joint", "arm_right_{}_joint", "arm"),
        ("l_shoulder_{}", "r_shoulder_{}", "arm"),
        ("LElbow{}", "RElbow{}", "arm"),
        ("left_s{}", "right_s{}", "arm"),
        ("leg_left_{}_joint", "leg_right_{}_joint", "leg"),
        ("LHip{}", "RHip{}", "leg"),
    ],
)
def test_limbs_have_the_side_and_the_kind_that_their_joints_name(
    left: str, right: str, kind: str
) -> None:
    model = limbs(("base", left, 7), ("base", right, 7), ("base", "neck_{}", 2))
    assert {chain.name for chain in chains(model)} == {f"left_{kind}", f"right_{kind}", "head"}


def test_fingers_on_one_limb_are_its_hand() -> None:
    arms = [(side, f"{side}_arm_{{}}") for side in ("left", "right")]
    fingers = [
        (f"{side}_arm_5_link", f"{side}_{finger}_{{}}", 2)
        for side, _ in arms
        for finger in ("thumb", "finger_a", "finger_b")
    ]
    found = chains(limbs(*(("base", name, 6) for _, name in arms), *fingers))
    hands = {chain.name: chain for chain in found if chain.tip is None}
    assert {chain.name for chain in found} == {"left_arm", "right_arm", "left_hand", "right_hand"}
    assert {name: len(hand.joints) for name, hand in hands.items()} == {
        "left_hand": 6,
        "right_hand": 6,
    }
    assert all(joint.name.startswith("left") for joint in hands["left_hand"].joints)


def test_chains_of_a_star_need_time_in_proportion_to_its_links() -> None:
    passed = {}
    for count in (200, 800):
        model, calls = limbs(*(("base", f"limb{k}_{{}}", 1) for k in range(count))), 0

        def count_calls(_frame: object, event: str, _argument: object) -> None:
            nonlocal calls
            calls += event == "call"

        sys.setprofile(count_calls)
        try:
            assert len(chains(model)) == count
        finally:
            sys.setprofile(None)
        passed[count] = calls
    assert passed[800] < 5 * passed[200]

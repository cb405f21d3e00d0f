"""Hands of public models: they open, and their pads press on each other."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.robot.chains import chains
from cbdsl.robot.tip_frame import shape_centre
from cbdsl.scaffold.hand import ProposedHand
from tests.robot.test_chains import read

GRIPPERS = ("franka_panda/panda.urdf", "xarm6_with_gripper.urdf", "robots/panda.urdf")


@pytest.mark.parametrize("name", GRIPPERS)
def test_hand_of_a_gripper_has_two_pads_that_face_each_other(name: str) -> None:
    model = read(name)
    (chain,) = (each for each in chains(model) if each.tip is None)
    hand = ProposedHand(model, chain.joints)
    tree = JointTree(joint for root in model.roots for joint in model.beyond(root))
    assert [*hand.postures] == ["open", "closed"]
    assert len(hand.pads) == 2
    apart = {}
    for posture, positions in hand.postures.items():
        at = {joint.name: q for joint, q in zip(chain.joints, positions, strict=True)}
        for joint in model.joints.values():
            if joint.mimic is not None and joint.mimic.joint in at:
                at[joint.name] = joint.mimic.ratio * at[joint.mimic.joint] + joint.mimic.offset
        placed = tree.place(at)
        frames = [placed[pad.link].child for pad in hand.pads]
        one, other = (
            frame.position + frame.rotation @ np.array(shape_centre(model, pad.link))
            for frame, pad in zip(frames, hand.pads, strict=True)
        )
        apart[posture] = float(np.linalg.norm(one - other))
        towards = (other - one) / apart[posture]
        normals = [f.rotation @ np.array(p.normal) for f, p in zip(frames, hand.pads, strict=True)]
        assert normals[0] @ towards > 0.7, posture
        assert normals[1] @ towards < -0.7, posture
    assert apart["open"] > apart["closed"] + 0.03


def test_hand_without_opposite_fingers_has_no_pads() -> None:
    model = read("kuka_iiwa/model.urdf")
    assert not ProposedHand(model, list(model.joints.values())[-2:-1]).pads


@pytest.mark.parametrize(
    ("name", "link", "offset"),
    [
        ("franka_panda/panda.urdf", "panda_grasptarget", (0.0, 0.0, 0.0)),
        ("robots/panda.urdf", "panda_hand", (0.0, 0.0, 0.1034)),
    ],
)
def test_span_of_sliding_fingers_is_distance_between_pads(
    name: str, link: str, offset: tuple[float, ...]
) -> None:
    model = read(name)
    (chain,) = (each for each in chains(model) if each.tip is None)
    hand = ProposedHand(model, chain.joints)
    hand.aim(link, offset)
    # The fingers slide apart from where their pads meet.
    assert hand.span == pytest.approx(2 * hand.postures["open"][0], abs=2e-3)


@pytest.mark.parametrize("name", GRIPPERS)
def test_pads_beside_a_tip_are_on_both_sides_of_it(name: str) -> None:
    model = read(name)
    (chain,) = (each for each in chains(model) if each.tip is None)
    hand = ProposedHand(model, chain.joints)
    tree = JointTree(joint for root in model.roots for joint in model.beyond(root))
    carrier = model.joints[chain.joints[0].name].parent
    hand.aim(carrier, hand.grip(carrier))
    at = {joint.name: q for joint, q in zip(chain.joints, hand.postures["closed"], strict=True)}
    for joint in model.joints.values():
        if joint.mimic is not None and joint.mimic.joint in at:
            at[joint.name] = joint.mimic.ratio * at[joint.mimic.joint] + joint.mimic.offset
    placed = tree.place({**model.rests, **at})
    frame = placed[carrier].child
    tip = frame.position + frame.rotation @ np.array(hand.grip(carrier))
    middles = [
        placed[pad.link].child.position + placed[pad.link].child.rotation @ np.array(pad.middle)
        for pad in hand.pads
    ]
    assert np.mean(middles, axis=0) == pytest.approx(tip, abs=2e-3)

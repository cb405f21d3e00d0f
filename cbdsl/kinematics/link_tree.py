"""Compiled forward kinematics of all links of a URDF model.

Controllers need a few links with their Jacobians; a world needs many links without. One compiled
pass over the tree takes less time than three links one by one.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cbdsl.kinematics.forward import JOINT, place_joints
from cbdsl.kinematics.pose import Pose, axis_of, displacement
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfJoint, UrdfModel


class LinkTree:
    """Links of a URDF model and the joints between them.

    Attributes:
        rows: Row of each link in ``placements``.
        placements: Placements of all links in the world: rotation by rows, then position, m, shape
            (links, 12); always the same array.
        chain: All arguments of ``place_joints`` after the joints' positions.
    """

    def __init__(self, model: UrdfModel, joints: Joints, base: str) -> None:
        ordered = list(model.beyond(base))
        self.rows: Mapping[str, int] = {base: 0} | {
            joint.child: row for row, joint in enumerate(ordered, 1)
        }
        tree = np.zeros(len(ordered), JOINT)
        for joint, row in zip(ordered, tree, strict=True):
            pose = Pose.at(joint.origin) @ displacement(joint, _still(joint, joints, model))
            row["parent"], row["slides"] = self.rows[joint.parent], joint.slides
            row["rotation"], row["origin"] = pose.rotation.ravel(), pose.position
            row["axis"] = axis_of(joint)
            # A passive joint follows one actuated joint, and an actuated one itself.
            ratios = _ratios(joint.name, joints)
            row["column"] = np.argmax(np.abs(ratios))
            row["ratio"] = ratios[row["column"]]
        self.placements: Floats = np.zeros((len(self.rows), 12))
        self.placements[0, [0, 4, 8]] = 1.0
        axes = np.zeros((len(ordered), 3))
        self.chain: tuple[Integers, Records, Floats, Floats]
        self.chain = np.arange(len(ordered)), tree, self.placements, axes
        self._poses = {link: _pose(self.placements[row]) for link, row in self.rows.items()}
        self.update(np.zeros(len(joints)))

    def update(self, positions: Floats) -> None:
        """Set the actuated joints' positions, rad, shape (n,)."""
        place_joints(positions, *self.chain)

    def pose(self, link: str) -> Pose:
        """Return the pose of a link, until the next update changes it."""
        return self._poses[link]


def _pose(placement: Floats) -> Pose:
    return Pose(placement[9:], placement[:9].reshape(3, 3))


def _ratios(joint: str, joints: Joints) -> Floats:
    """Return a joint's motion per motion of each actuated one, shape (n,); 0 if it rests."""
    row = joints.index.get(joint)
    return np.zeros(len(joints)) if row is None else joints.expansion[row]


def _still(joint: UrdfJoint, joints: Joints, model: UrdfModel) -> float:
    """Return a joint's position where all actuated joints are at 0, rad or m."""
    row = joints.index.get(joint.name)
    return model.rests.get(joint.name, 0.0) if row is None else float(joints.offsets[row])

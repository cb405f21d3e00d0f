"""Forward kinematics of the whole robot in one pass.

Controllers need a few links with their Jacobians; a world needs many links without. One compiled
pass over the tree takes less time than three links one by one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from cbdsl.kinematics.displacement import displacement
from cbdsl.kinematics.forward import multiply, place_point, rotate
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Booleans, Floats, Rows
from cbdsl.numeric.compiled import compiled_once
from cbdsl.numeric.vector import copy, dot
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfJoint, UrdfModel


class Tree:
    """Links of a URDF model and the joints between them.

    Attributes:
        rows: Row of each link in ``placements``.
        placements: Placements of all links in the world: rotation by rows, then position, m, shape
            (links, 12); always the same array.
        chain: All arguments of ``place`` after the joints' positions.
    """

    def __init__(self, model: UrdfModel, joints: Joints, base: str) -> None:
        leaving: dict[str, list[UrdfJoint]] = {}
        for joint in model.joints.values():
            leaving.setdefault(joint.parent, []).append(joint)
        ordered = list(_outwards(leaving, base))
        self.rows: Mapping[str, int] = {base: 0} | {
            joint.child: row for row, joint in enumerate(ordered, 1)
        }
        parents = np.array([self.rows[joint.parent] for joint in ordered], np.intp)
        ratios = np.array([_ratios(joint.name, joints) for joint in ordered])
        # A passive joint follows one actuated joint, and an actuated one itself.
        columns = np.argmax(np.abs(ratios), axis=1)
        follows = np.column_stack((parents, columns))
        poses = [Pose.at(joint.origin) @ _still(joint, joints, model) for joint in ordered]
        parts = np.array(
            [
                [*pose.rotation.ravel(), *pose.position, *_axis(joint), ratio, joint.slides]
                for joint, pose, ratio in zip(
                    ordered, poses, ratios[np.arange(len(ordered)), columns], strict=True
                )
            ]
        )
        # No joint has been placed yet.
        angles, moved = np.full(len(ordered), np.nan), np.zeros(len(self.rows), np.bool_)
        self.placements: Floats = np.zeros((len(self.rows), 12))
        self.chain = follows, parts, angles, moved, self.placements
        self.placements[0, [0, 4, 8]] = 1.0
        self._poses = {link: _pose(self.placements[row]) for link, row in self.rows.items()}
        self.update(np.zeros(len(joints)))

    def update(self, positions: Floats) -> None:
        """Set the actuated joints' positions, rad, shape (n,)."""
        place(positions, *self.chain)

    def pose(self, link: str) -> Pose:
        """Return the pose of a link, until the next update changes it."""
        return self._poses[link]


def _pose(placement: Floats) -> Pose:
    return Pose(placement[9:], placement[:9].reshape(3, 3))


def _ratios(joint: str, joints: Joints) -> Floats:
    """Return a joint's motion per motion of each actuated one, shape (n,); 0 if it rests."""
    row = joints.index.get(joint)
    return np.zeros(len(joints)) if row is None else joints.expansion[row]


def _still(joint: UrdfJoint, joints: Joints, model: UrdfModel) -> Pose:
    """Return a joint's displacement where all actuated joints are at 0."""
    row = joints.index.get(joint.name)
    at = model.rests.get(joint.name, 0.0) if row is None else float(joints.offsets[row])
    return displacement(joint, at)


def _axis(joint: UrdfJoint) -> Floats:
    axis = np.array(joint.axis)
    # The axis of a fixed joint means nothing, and is 0 in some models.
    unit: Floats = axis / (np.linalg.norm(axis) or 1.0)
    return unit


def _outwards(leaving: Mapping[str, list[UrdfJoint]], base: str) -> Iterator[UrdfJoint]:
    """Yield all joints beyond a link, each after its parent joint."""
    for joint in leaving.get(base, ()):
        yield joint
        yield from _outwards(leaving, joint.child)


@compiled_once
def place(
    positions: Floats,
    follows: Rows,
    joints: Floats,
    angles: Floats,
    moved: Booleans,
    placed: Floats,
) -> None:
    """Place all links beyond the base that have moved.

    Args:
        positions: Positions of the actuated joints, rad, shape (n,).
        follows: Row of each joint's parent link, and index of the actuated joint that it follows,
            shape (joints, 2).
        joints: Origin of each joint in its parent link's frame, as a placement, the unit vector of
            its axis, the ratio at which it follows, and whether it slides, shape (joints, 17).
        angles: Positions of all joints when they were last placed, rad or m, shape (joints,).
        moved: Output: whether each link moves, shape (1 + joints,); the base does not.
        placed: Placements of all links, shape (1 + joints, 12).
    """
    turn, turned = np.empty(9), np.empty(9)
    for joint in range(len(joints)):
        local = joints[joint]
        angle = local[15] * positions[follows[joint, 1]]
        moved[joint + 1] = moved[follows[joint, 0]] or angle != angles[joint]
        if not moved[joint + 1]:
            continue
        angles[joint] = angle
        parent, own = placed[follows[joint, 0]], placed[joint + 1]
        place_point(parent, local[9:12], own[9:])
        multiply(parent, local, turned)
        if local[16]:
            for i in range(3):
                own[i + 9] += angle * dot(turned[3 * i : 3 * i + 3], local[12:15])
            copy(own[:9], turned, 1.0)
        else:
            rotate(local[12:15], angle, turn)
            multiply(turned, turn, own)

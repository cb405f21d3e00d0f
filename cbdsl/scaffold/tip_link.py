"""Far ends of hands, in which direction they work, and tips that are not there."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.kinematics.joint_tree import JointTree
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.tip_frame import shape_corners
from cbdsl.robot.urdf import Numbers, UrdfError, UrdfModel

# Distance from the far end of a hand below which a tip counts as there, m.
_END = 0.03
_RIGHT = math.pi / 2
# Roll and pitch of the frame whose z axis is an axis of the tip, by its number and sign.
_TURNS = {
    (0, 1): (0.0, _RIGHT), (0, -1): (0.0, -_RIGHT), (1, 1): (-_RIGHT, 0.0),
    (1, -1): (_RIGHT, 0.0), (2, 1): (0.0, 0.0), (2, -1): (math.pi, 0.0),
}  # fmt: skip


def hand_corners(model: UrdfModel, last: str, tip: str) -> Floats:
    """Return the corners of the shapes beyond an arm, in the frame of its tip, m, shape (n, 3).

    Args:
        model: Model of the robot.
        last: Link that the last joint moves; its origin is the first point.
        tip: Link of the tip.
    """
    tree = JointTree(joint for root in model.roots for joint in model.beyond(root))
    placed = tree.place(model.rests)
    end, points = placed[tip].child, [placed[last].child.position]
    try:
        for link in (last, *(joint.child for joint in model.beyond(last))):
            at = placed[link].child
            points += [at.position + at.rotation @ np.array(c) for c in shape_corners(model, link)]
    except UrdfError:
        pass  # the document gets a diagnostic for it
    return (np.array(points) - end.position) @ end.rotation


# Standoffs, funnels and gazes take the z axis of a tip as the direction in which it works. Many
# public models have a tool along x instead, or a flange behind their hand. The direction is here
# the axis of the tip along which the box around the hand is farthest from the last joint, if that
# is beyond half of its width: a flat flange shows no direction.
def working_frame(points: Floats, offset: Numbers) -> tuple[float, ...] | None:
    """Return the frame at the far end of a hand whose z axis is the direction in which it works.

    Args:
        points: Points of ``hand_corners``.
        offset: Position of the tip in the frame of its link, m.

    Returns:
        Position, m, with roll, pitch and yaw, rad; ``None`` if the tip is that frame already.
    """
    joint, place = points[0], np.array(offset)
    low, high = points[1:].min(axis=0, initial=0.0), points[1:].max(axis=0, initial=0.0)
    middle = (low + high) / 2 - joint
    axis = int(np.abs(middle).argmax())
    sign = 1 if middle[axis] > 0 else -1
    if abs(middle[axis]) < np.delete(high - low, axis).max() / 2:
        axis, sign = 2, 1
    beyond = sign * ((high if sign > 0 else low)[axis] - place[axis])
    if beyond > _END:
        place[axis] += sign * beyond
    elif (axis, sign) == (2, 1):
        return None
    return (*(round(float(each), 4) for each in place), *_TURNS[axis, sign], 0.0)

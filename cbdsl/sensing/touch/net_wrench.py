"""Net wrench of a hand: sum of its fingers' forces, torques and moments; compiled.

Its Jacobian is the cast force -> displacement (Eq 3.37 to 3.39). The model is that each fingertip
presses on a spring, so that the moment of a force grows with the force.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cbdsl.kinematics.forward import move_point, place_point
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled_once


class Fingertips(NamedTuple):
    """Fingertips of a hand in the model, as ``net_wrench`` takes them.

    Attributes:
        frames: Numbers of the frames that carry the fingertips, shape (k,).
        origins: Origins of the fingertips in these frames, m, shape (k, 3).
        support: Joints that move each fingertip, padded with -1, shape (k, most).
    """

    frames: Integers
    origins: Floats
    support: Integers

    @classmethod
    def of(cls, kinematics: Kinematics, links: list[str]) -> Fingertips:
        """Return the fingertips of some links."""
        placed = [kinematics.link(link) for link in links]
        support = np.full((len(links), max(len(link.support) for link in placed)), -1)
        for row, link in zip(support, placed, strict=True):
            row[: len(link.support)] = link.support
        frames = np.array([link.frame for link in placed], dtype=np.int64)
        return cls(frames, np.array([link.position for link in placed]), support)


@compiled_once
def net_wrench(
    loads: Floats,
    centre: Floats,
    stiffness: Floats,
    numbers: Integers,
    origins: Floats,
    support: Integers,
    joints: Records,
    frames: Floats,
    axes: Floats,
    value: Floats,
    jacobian: Floats,
) -> None:
    """Compute the net wrench of a hand about a point, and its Jacobian.

    Args:
        loads: Loads of the hand's cells, N and N m, world frame, shape (k, 6).
        centre: Reference point of the torques, m, world frame, shape (3,).
        stiffness: Stiffness of the touched objects, N/m and N m/rad, shape (2,).
        numbers, origins, support: Attributes of ``Fingertips``.
        joints, frames, axes: Joint tree, frames and axes, as in ``place_joints``.
        value: Output: net wrench, N and N m, shape (6,).
        jacobian: Output: change of the wrench per joint, shape (6, n).
    """
    value[:], jacobian[:] = 0.0, 0.0
    tip, lever = np.empty(3), np.empty(3)
    own = np.empty(jacobian.shape)
    for cell in range(len(loads)):
        place_point(frames[numbers[cell]], origins[cell], tip)
        own[:] = 0.0
        count = 0
        while count < support.shape[1] and support[cell, count] >= 0:
            count += 1
        move_point(tip, support[cell, :count], joints, frames, axes, own)
        for i in range(3):
            lever[i] = tip[i] - centre[i]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            value[i] += loads[cell, i]
            value[3 + i] += loads[cell, 3 + i]
            value[3 + i] += lever[j] * loads[cell, k] - lever[k] * loads[cell, j]
            for joint in range(jacobian.shape[1]):
                jacobian[i, joint] += stiffness[0] * own[i, joint]
                moment = lever[j] * own[k, joint] - lever[k] * own[j, joint]
                jacobian[3 + i, joint] += stiffness[1] * own[3 + i, joint] + stiffness[0] * moment

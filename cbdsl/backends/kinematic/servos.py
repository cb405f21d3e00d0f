"""Ideal servos: joints reach their references as far as speeds and limits allow.

Joints carry links: both move in one compiled call.
"""

from __future__ import annotations

import numpy as np

from cbdsl.kinematics.forward import place_joints
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled_once
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf import UrdfModel


class Servos:
    """Servos of all actuated joints.

    Args:
        joints: Actuated joints.
        model: URDF model with their limits.
        tree: Tree of the links that they move.
        period: Period of a control tick, s.
    """

    def __init__(self, joints: Joints, model: UrdfModel, tree: LinkTree, period: float) -> None:
        self._period = period
        self._chain = tree.chain
        limits = [model.joints[name] for name in joints.names]
        self._limits = np.array([(period * j.velocity, j.lower, j.upper) for j in limits]).T.copy()

    def follow(self, positions: Floats, reference: Floats) -> tuple[Floats, Floats]:
        """Move the joints by one tick, and place the links.

        Args:
            positions: Positions of the joints now, rad, shape (n,).
            reference: References of the joints, rad, shape (n,).

        Returns:
            Reached positions, rad, and mean velocities during the tick, rad/s, shape (n,) each.
        """
        reached, velocities = np.empty((2, len(positions)))
        _follow(positions, reference, self._limits, self._period, reached, velocities, *self._chain)
        return reached, velocities


@compiled_once
def _follow(
    positions: Floats,
    reference: Floats,
    limits: Floats,
    period: float,
    reached: Floats,
    velocities: Floats,
    moving: Integers,
    joints: Records,
    frames: Floats,
    axes: Floats,
) -> None:
    """Write reached positions and velocities, and place the links.

    ``limits`` are the largest step, the lower and the upper limit, shape (3, n); the arguments
    after ``velocities`` are a tree's chain.
    """
    for joint in range(len(positions)):
        step, lower, upper = limits[0, joint], limits[1, joint], limits[2, joint]
        least, most = positions[joint] - step, positions[joint] + step
        # Position limits come last: they hold even for a joint that starts outside of them.
        wanted = min(max(reference[joint], least), most)
        reached[joint] = min(max(wanted, lower), upper)
        velocities[joint] = (reached[joint] - positions[joint]) / period
    place_joints(reached, moving, joints, frames, axes)

"""Actuated joints of a robot, in one fixed order, and the passive joints coupled to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.arrays import Booleans, Floats


class Joints:
    """Names and indices of the actuated joints, effector by effector in document order.

    Attributes:
        names: Names of the n actuated joints.
        passive: Names of the m coupled joints.
        all: Names of the actuated, then the passive joints.
        counted: True for actuated joints of effectors whose whole turns count, shape (n,).
    """

    def __init__(self, robot: RobotDocument) -> None:
        self.names: tuple[str, ...] = tuple(
            joint for effector in robot.effectors.values() for joint in effector.joints
        )
        self.counted: Booleans = np.array(
            [e.count_turns for e in robot.effectors.values() for _ in e.joints], dtype=bool
        )
        self.passive: tuple[str, ...] = tuple(robot.couplings)
        self.all: tuple[str, ...] = self.names + self.passive
        self.index: Mapping[str, int] = {name: i for i, name in enumerate(self.all)}
        self._effectors = {
            name: self.pick(robot.joints(name)) for name in (*robot.effectors, *robot.groups)
        }
        #: Angles of all joints per angles of the actuated ones, shape (n + m, n).
        self.expansion: Floats = np.eye(len(self.all), len(self.names))
        # A passive joint p that follows the actuated joint a obeys q_p = ratio * q_a + offset. All
        # positions are thus E q + o, with the identity in the first n rows of E and one entry in
        # each further row. Derivatives need E alone, because o is constant.
        for name, coupling in robot.couplings.items():
            self.expansion[self.index[name], self.index[coupling.follows]] = coupling.ratio
        #: Positions of all joints if the actuated ones are at 0, rad or m, shape (n + m,).
        self.offsets: Floats = np.zeros(len(self.all))
        self.offsets[len(self.names) :] = [each.offset for each in robot.couplings.values()]

    def __len__(self) -> int:
        return len(self.names)

    def of(self, effector: str) -> NDArray[np.intp]:
        """Return the indices of an effector's or a group's joints among the actuated ones."""
        return self._effectors[effector]

    def pick(self, joints: Sequence[str]) -> NDArray[np.intp]:
        """Return the indices of the named joints among all."""
        return np.array([self.index[joint] for joint in joints])

    def expand(self, positions: Floats) -> Floats:
        """Return positions of all joints, shape (n + m,), from actuated ones, shape (n,)."""
        return self.expansion @ positions + self.offsets

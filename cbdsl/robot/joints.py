"""The actuated joints of a robot, in one fixed order, and the passive joints they carry along."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


class Joints:
    """Names and indices of the actuated joints: effector by effector, as the robot file has them.

    Attributes:
        names: the actuated joints, n of them.
        passive: the coupled joints, m of them.
        all: actuated, then passive joints.
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
        for name, coupling in robot.couplings.items():
            self.expansion[self.index[name], self.index[coupling.follows]] = coupling.ratio
        #: Positions of all joints where the actuated ones are at 0, rad or m, shape (n + m,).
        self.offsets: Floats = np.zeros(len(self.all))
        self.offsets[len(self.names) :] = [each.offset for each in robot.couplings.values()]

    def __len__(self) -> int:
        return len(self.names)

    def of(self, effector: str) -> NDArray[np.intp]:
        """Indices of the joints of an effector or a group among the actuated ones."""
        return self._effectors[effector]

    def pick(self, joints: Sequence[str]) -> NDArray[np.intp]:
        """Indices of the named joints among all."""
        return np.array([self.index[joint] for joint in joints])

    def expand(self, positions: Floats) -> Floats:
        """Angles of all joints, shape (n + m,), from those of the actuated ones, shape (n,)."""
        return self.expansion @ positions + self.offsets

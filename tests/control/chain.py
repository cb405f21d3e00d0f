"""Serial chains of revolute joints in numpy: robots whose signals the control tests need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from tests.control.evaluation import Signal


@dataclass(frozen=True)
class Chain:
    """Joint i turns about ``axes[i]`` in its parent's frame; ``links[i]`` leads to the next."""

    axes: Floats  # (n, 3), unit vectors
    links: Floats  # (n, 3), m

    @classmethod
    def planar(cls, joints: int, length: float = 1.0) -> Chain:
        """Return a chain with joints about z and links along x, ``length`` in all."""
        return cls(
            np.tile([0.0, 0.0, 1.0], (joints, 1)), np.tile([length / joints, 0.0, 0.0], (joints, 1))
        )

    @classmethod
    def random(cls, joints: int, rng: np.random.Generator) -> Chain:
        axes = rng.normal(size=(joints, 3))
        return cls(
            axes / np.linalg.norm(axes, axis=1, keepdims=True),
            rng.uniform(-0.3, 0.3, (joints, 3)),
        )

    @property
    def joints(self) -> int:
        return len(self.axes)

    def pose(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """Return tip position (3,), rotation (3, 3) and Jacobian (6, n), linear above angular."""
        rotation, point = np.eye(3), np.zeros(3)
        origins, directions = [], []
        for axis, link, angle in zip(self.axes, self.links, q, strict=True):
            origins.append(point)
            directions.append(rotation @ axis)
            rotation = rotation @ exp(angle * axis)
            point = point + rotation @ link
        angular = np.array(directions)
        linear = np.cross(angular, point - np.array(origins))
        return point, rotation, np.vstack((linear.T, angular.T))

    def hessian(self, q: Floats) -> Floats:
        """Return second derivatives of the tip's position and rotation by the joints, (6, n, n)."""
        _, _, jacobian = self.pose(q)
        linear, angular = jacobian[:3].T, jacobian[3:].T
        # A joint turns the levers and axes of those behind it.
        behind = np.triu(np.ones((len(q), len(q))))[..., None]
        moved = behind * np.cross(angular[:, None], linear[None])
        turned = 0.5 * behind * np.cross(angular[:, None], angular[None])
        moved += np.where(np.eye(len(q))[..., None], 0.0, moved.swapaxes(0, 1))
        return np.concatenate((moved, turned + turned.swapaxes(0, 1)), axis=2).transpose(2, 0, 1)

    def signal(self, kind: str, q: Floats) -> Signal:
        """Return the chain's tip, or its joints, as a signal of a type."""
        position, rotation, jacobian = self.pose(q)
        if kind == "position":
            return Signal(position, jacobian[:3])
        if kind == "orientation":
            return Signal(rotation, jacobian[3:])
        if kind == "pose":
            transform = np.eye(4)
            transform[:3, :3], transform[:3, 3] = rotation, position
            return Signal(transform, jacobian)
        return Signal(q, np.eye(self.joints))

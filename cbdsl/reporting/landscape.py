"""Internal models as functions: density of an angle relative to the initial uniform density."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.reporting.learned import InternalModel

Floats = NDArray[np.float64]

#: Number of evaluated angles of a joint.
POINTS = 181

_erf = np.vectorize(math.erf, otypes=[float])


class Landscape:
    """Density within joint limits, as sampled: samples beyond the limits are drawn again.

    Values are relative to the uniform density over all joints: 1 is as likely as before learning.

    Args:
        model: Density with the limits of its joints.
    """

    def __init__(self, model: InternalModel) -> None:
        density = model.document.density
        if density.form == "gaussian":
            centers, spread = [density.mean], density.deviation
        else:
            centers, spread = list(density.samples), density.bandwidth
        self.centers: Floats = np.array(centers)
        self.spread: Floats = np.array(spread)
        # A joint that turns without limits is shown, and drawn uniformly, over one turn.
        turn = math.pi
        self.lower = np.array([-turn if math.isinf(j.lower) else j.lower for j in model.joints])
        self.upper = np.array([turn if math.isinf(j.upper) else j.upper for j in model.joints])
        self.uniform = density.uniform
        # The part of each kernel within the limits of each joint, shape (kernels, joints).
        self._inside = self._below(self.upper) - self._below(self.lower)
        # Keeps the density finite if its mass within the limits is close to zero.
        self._total = max(float(self._inside.prod(axis=1).sum()), np.finfo(float).tiny)

    def _below(self, angle: Floats) -> Floats:
        part: Floats = 0.5 * (1 + _erf((angle - self.centers) / (self.spread * math.sqrt(2))))
        return part

    def _kernels(self, joint: int, angles: Floats) -> Floats:
        """Return each kernel along one joint, shape (kernels, angles), times the joint's range."""
        spread, span = self.spread[joint], self.upper[joint] - self.lower[joint]
        z = (angles - self.centers[:, joint, None]) / spread
        height: Floats = span * np.exp(-0.5 * z**2) / (spread * math.sqrt(2 * math.pi))
        return height

    def _mixed(self, learned: Floats) -> Floats:
        mixed: Floats = (1 - self.uniform) * learned / self._total
        return mixed + self.uniform

    def along(self, joint: int, angles: Floats) -> Floats:
        """Return the marginal density of one joint's angle, shape (angles,)."""
        others = np.delete(self._inside, joint, axis=1).prod(axis=1)
        return self._mixed(others @ self._kernels(joint, angles))

    def over(self, first: Floats, second: Floats) -> Floats:
        """Return the joint density of the angles of a model with two joints.

        Returns:
            Density, shape (second, first).
        """
        return self._mixed(self._kernels(1, second).T @ self._kernels(0, first))

    def angles(self, joint: int) -> Floats:
        """Return angles of a joint from limit to limit, rad, shape (POINTS,)."""
        angles: Floats = np.linspace(self.lower[joint], self.upper[joint], POINTS)
        return angles

    def peak(self) -> tuple[tuple[float, ...], float]:
        """Return the most likely angles, rad, and their density.

        Returns:
            Angles and density at the joint maximum of two joints. For other numbers of joints, the
            maximum of each marginal density, and the largest of these densities.
        """
        joints = range(len(self.lower))
        if len(joints) == 2:
            values = self.over(self.angles(0), self.angles(1))
            row, column = np.unravel_index(values.argmax(), values.shape)
            return (float(self.angles(0)[column]), float(self.angles(1)[row])), float(values.max())
        heights = [self.along(joint, self.angles(joint)) for joint in joints]
        best = tuple(float(self.angles(joint)[heights[joint].argmax()]) for joint in joints)
        return best, float(max(height.max() for height in heights))

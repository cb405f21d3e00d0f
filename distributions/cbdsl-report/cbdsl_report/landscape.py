"""Internal models as functions: density of an angle relative to the initial uniform density."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.extend.backend import Floats
from cbdsl_report.learned_files import InternalModel

#: Number of evaluated angles of a joint.
POINTS = 181
# Turns in both directions over which a kernel of an endless joint is added up.
_REPEATED = 2

_erf = np.vectorize(math.erf, otypes=[float])


# Model of the density, relative to the uniform one:
#   f(x) = u + (1 - u) * sum_k prod_j r_j N(x_j; c_kj, s_j) / sum_k prod_j m_kj.
# The share u is uniform. Kernel k has the centre c_kj and the deviation s_j along joint j. The
# joint has the range r_j, and m_kj is the mass of the kernel within its limits. A Gaussian model is
# the case of one kernel. The normalization divides by the mass of whole configurations, because a
# sample is drawn again if any joint is beyond its limits. The marginal of one joint weights kernel
# k by the masses m_ki of all other joints i. For an endless joint, kernels are repeated by whole
# turns, a wrapped Gaussian. Turns beyond the second are at least 4 pi from every shown angle, and
# are neglected.
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
        # Turns by which its kernels are repeated: a position is the same after each of them.
        self._turns = [
            2.0 * math.pi * np.arange(-_REPEATED, _REPEATED + 1)
            if joint.is_endless
            else np.zeros(1)
            for joint in model.joints
        ]
        for place, joint in enumerate(model.joints):
            if joint.is_endless:
                angles = self.centers[:, place]
                self.centers[:, place] = angles - 2.0 * turn * np.round(angles / (2.0 * turn))
        self.uniform = density.uniform
        # The part of each kernel within the limits of each joint, shape (kernels, joints).
        self._inside = np.stack([self._mass(joint) for joint in range(len(self.lower))], axis=1)
        # Keeps the density finite if its mass within the limits is close to zero.
        self._total = max(float(self._inside.prod(axis=1).sum()), np.finfo(float).tiny)

    def _mass(self, joint: int) -> Floats:
        """Return the part of each kernel between the limits of a joint, shape (kernels,)."""
        centers = self.centers[:, joint, None] + self._turns[joint]
        width = self.spread[joint] * math.sqrt(2)
        below = _erf((self.lower[joint] - centers) / width)
        mass: Floats = 0.5 * (_erf((self.upper[joint] - centers) / width) - below).sum(axis=1)
        return mass

    def _kernels(self, joint: int, angles: Floats) -> Floats:
        """Return each kernel along one joint, shape (kernels, angles), times the joint's range."""
        spread, span = self.spread[joint], self.upper[joint] - self.lower[joint]
        centers = self.centers[:, joint, None, None] + self._turns[joint][:, None]
        z = (angles - centers) / spread
        heights = span * np.exp(-0.5 * z**2) / (spread * math.sqrt(2 * math.pi))
        height: Floats = heights.sum(axis=1)
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
        # A grid over more than two joints would be too large. The maxima of marginals need not
        # belong to one configuration that is likely.
        heights = [self.along(joint, self.angles(joint)) for joint in joints]
        best = tuple(float(self.angles(joint)[heights[joint].argmax()]) for joint in joints)
        return best, float(max(height.max() for height in heights))

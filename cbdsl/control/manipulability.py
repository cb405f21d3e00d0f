"""The measure of manipulability (Section 3.1.3 b, Eq 3.5)."""

from __future__ import annotations

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.potential import Evaluation, gradient_descent
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.program.controller import Controller


class Manipulability:
    """phi = -w with w = sqrt(det(J J^T)), the volume that a ball of joint velocities is mapped to.

    With C_j the derivative of J by joint j, dw/dq_j = w trace(C_j J^#). The singular values s_i
    of J, with singular vectors u_i and v_i, give w J^# = sum_i (w / s_i) v_i u_i^T as products of
    the other singular values, which is bounded everywhere. At a singularity itself w has a kink:
    one vanishing s_i, and a v_i that may be any null vector of J. Whichever is taken, the gradient
    points to where w grows, if it does not vanish.

    Several tips at once, as rows of one Jacobian, give the product of their manipulabilities
    where they have no joint in common.
    """

    @classmethod
    def build(cls, controller: Controller, body: Body) -> Manipulability:
        """The manipulability of a checked controller; all it needs is in the signal."""
        return cls()

    def evaluate(self, signal: Signal, reference: Floats | None) -> Evaluation:
        """See ``Potential.evaluate``; the reference plays no part.

        Args:
            signal: a tip's position or pose, or several of them stacked, with curvature.
            reference: not used.
        """
        jacobian, curvature = signal.jacobian, signal.curvature
        rows, joints = jacobian.shape
        if curvature is None:
            raise SignalError(f"manipulability needs the curvature of {signal.name}")
        if rows > joints:
            raise SignalError(
                f"{signal.name} has {rows} components, which {joints} joints cannot all move: "
                "its manipulability is 0 everywhere"
            )
        volume, cofactors = _volume(jacobian)
        slope = cofactors.ravel().dot(curvature.reshape(rows * joints, joints))
        return gradient_descent(-volume, -slope)


def _volume(jacobian: Floats) -> tuple[float, Floats]:
    """w, and its derivative by the entries of J, which is w times the transpose of J^#, (m, n)."""
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    # Products of all values but one: of those before it, times those after it.
    before = np.concatenate(((1.0,), np.cumprod(values[:-1])))
    after = np.concatenate((np.cumprod(values[:0:-1])[::-1], (1.0,)))
    cofactors: Floats = (left * (before * after)).dot(right)
    return float(before[-1] * values[-1]), cofactors

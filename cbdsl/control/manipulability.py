"""The measure of manipulability (Section 3.1.3 b, Eq 3.5)."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.potential import Evaluation, gradient_descent
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.program.controller import Controller

# The determinant of J J^T above which, as part of its trace to the m-th power, J is so far from a
# singularity that squaring its condition costs no more than 1e-7 of the gradient.
_CLEAR = 1e-9


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
    gram = jacobian.dot(jacobian.T)
    least = _CLEAR * float(np.vdot(jacobian, jacobian)) ** len(gram)
    square, inverse = (_inverse_3 if len(gram) == 3 else _inverse)(gram, least)
    if inverse is None:
        return _volume_near_singularity(jacobian)
    volume = math.sqrt(square)
    cofactors: Floats = volume * inverse.dot(jacobian)
    return volume, cofactors


def _inverse(gram: Floats, least: float) -> tuple[float, Floats | None]:
    """The determinant, and the inverse where that is above ``least``."""
    determinant = float(np.linalg.det(gram))
    if not determinant > least:
        return determinant, None
    return determinant, np.asarray(np.linalg.inv(gram), dtype=np.float64)


def _inverse_3(gram: Floats, least: float) -> tuple[float, Floats | None]:
    """As above, for three rows: a sixth of the time."""
    a, b, c, _, d, e, _, _, f = gram.ravel().tolist()
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * p + b * q + c * r
    if not determinant > least:
        return determinant, None
    s, t, u = a * f - c * c, b * c - a * e, a * d - b * b
    adjugate = np.array(((p, q, r), (q, s, t), (r, t, u)))
    return determinant, adjugate / determinant


def _volume_near_singularity(jacobian: Floats) -> tuple[float, Floats]:
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    sizes = values.tolist()
    others = [math.prod(sizes[:i] + sizes[i + 1 :]) for i in range(len(sizes))]
    cofactors: Floats = (left * others).dot(right)
    return math.prod(sizes), cofactors

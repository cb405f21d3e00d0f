"""The measure of manipulability (Section 3.1.3 b, Eq 3.5)."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.body import Body
from cbdsl.control.composition import Integers
from cbdsl.control.potential import MANIPULABILITY, Compiled, Evaluation, gradient_descent
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.numeric.compiled import compiled, compiled_once
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

    def __init__(self) -> None:
        self.size = 1
        self.compiled = Compiled(MANIPULABILITY, np.zeros((0, 0)))

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
        slope = np.empty(joints)
        size = volume(jacobian, curvature, np.arange(joints), slope)
        if math.isnan(size):
            size, cofactors = _volume_near_singularity(jacobian)
            slope = cofactors.ravel().dot(curvature.reshape(rows * joints, joints))
        return gradient_descent(-size, -slope)


@compiled_once
def volume(jacobian: Floats, curvature: Floats, columns: Integers, slope: Floats) -> float:
    """w of some joints of a Jacobian, or NaN where that is near a singularity.

    The derivative of w by the entries of J is w (J J^T)^-1 J; J J^T = L L^T (Cholesky).

    Args:
        jacobian: shape (m, all).
        curvature: its derivative, shape (m, all, all).
        columns: the joints, shape (n,); -1 for one that moves nothing.
        slope: becomes the derivative of w by the joints, shape (n,).
    """
    rows, joints = len(jacobian), len(columns)
    slope[:] = 0.0
    if curvature.shape != (rows, jacobian.shape[1], jacobian.shape[1]) or rows > joints:
        return math.nan
    gram = _gram(jacobian, columns)
    least = _CLEAR * np.trace(gram) ** rows
    square = _factorize(gram)
    if not square > least:
        return math.nan
    size, cofactors = math.sqrt(square), np.empty(rows)
    for column in columns:
        if column < 0:
            continue
        _solve(gram, jacobian[:, column], cofactors)
        for i in range(rows):
            for place in range(joints):
                if columns[place] >= 0:
                    slope[place] += size * cofactors[i] * curvature[i, column, columns[place]]
    return size


@compiled
def _gram(rows: Floats, columns: Integers) -> Floats:
    products = np.zeros((len(rows), len(rows)))
    for i in range(len(rows)):
        for j in range(len(rows)):
            for column in columns:
                if column >= 0:
                    products[i, j] += rows[i, column] * rows[j, column]
    return products


@compiled
def _factorize(gram: Floats) -> float:
    """Make the lower triangle of a Gram matrix (m, m) L; returns its determinant."""
    square = 1.0
    for i in range(len(gram)):
        for j in range(i + 1):
            for k in range(j):
                gram[i, j] -= gram[i, k] * gram[j, k]
            if i != j:
                gram[i, j] /= gram[j, j]
        square *= gram[i, i]
        if not gram[i, i] > 0.0:
            return 0.0
        gram[i, i] = math.sqrt(gram[i, i])
    return square


@compiled
def _solve(lower: Floats, wanted: Floats, found: Floats) -> None:
    """Solve ``L L^T found = wanted`` for a triangular L (m, m)."""
    rows = len(lower)
    for i in range(rows):
        rest = wanted[i]
        for k in range(i):
            rest -= lower[i, k] * found[k]
        found[i] = rest / lower[i, i]
    for i in range(rows - 1, -1, -1):
        rest = found[i]
        for k in range(i + 1, rows):
            rest -= lower[k, i] * found[k]
        found[i] = rest / lower[i, i]


def _volume_near_singularity(jacobian: Floats) -> tuple[float, Floats]:
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    sizes = values.tolist()
    others = [math.prod(sizes[:i] + sizes[i + 1 :]) for i in range(len(sizes))]
    cofactors: Floats = (left * others).dot(right)
    return math.prod(sizes), cofactors

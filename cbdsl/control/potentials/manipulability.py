"""Measure of manipulability (Section 3.1.3 b, Eq 3.5).

phi = -w with w = sqrt(det(J J^T)), the volume that a ball of joint velocities is mapped to. The
value is J itself, and its Jacobian the curvature, so that only dphi/dJ is needed here. The
derivative of w by the entries of J is w (J J^T)^-1 J. By the singular value
decomposition of J, it is the sum of (w / s_i) u_i v_i^T. The factors are products of the other
singular values, so that it is bounded everywhere. At a singularity w has a kink: one s_i vanishes,
and v_i may be any null vector of J. For every choice, the gradient points to growing w unless it
vanishes: where several s_i do, see ``_LEAST``.

Several tips simultaneously, as rows of one Jacobian, give the product of their manipulabilities if
they have no joint in common.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.control.basis import jacobi_svd
from cbdsl.control.potential import Potential, Rule, potential
from cbdsl.control.setting import Setting
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import add, copy, dot, fill, norm
from cbdsl.program.controller import Controller

# Determinant of J J^T, as part of its trace to the m-th power, above which J is far from a
# singularity. Squaring its condition then costs no more than 1e-7 of the gradient.
_CLEAR = 1e-9
# Share of the largest singular value below which two of them vanish together.
_LEAST = 0.01


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the manipulability of a controller's tips by its joints.

    Raises:
        ValueError: If there are fewer joints than components to move.
    """
    joints = len(controller.joints)
    return of_jacobian(setting.components // joints, joints)


def of_jacobian(rows: int, joints: int) -> Potential:
    """Return the manipulability of a Jacobian of shape (rows, joints), in row-major order."""
    if rows > joints:
        raise ValueError(
            f"{joints} joints cannot all move {rows} components: "
            "their manipulability is 0 everywhere"
        )
    return Potential(volume, 1, Rule.DESCENT, np.array([float(rows)]))


@potential
def volume(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return -w of a Jacobian; parameter: its number of rows."""
    rows = int(parameters[0])
    jacobian = value.reshape((rows, len(value) // rows))
    gradient = slope[0].reshape(jacobian.shape)
    gram, trace = _gram(jacobian)
    square = _factorize(gram)
    if not square > _CLEAR * trace**rows:
        return -_volume_near_singularity(jacobian, gradient)
    size, cofactors = math.sqrt(square), np.empty(rows)
    for column in range(jacobian.shape[1]):
        for i in range(rows):
            cofactors[i] = jacobian[i, column]
        _solve(gram, cofactors)
        for i in range(rows):
            gradient[i, column] = -size * cofactors[i]
    return -size


@compiled
def _gram(rows: Floats) -> tuple[Floats, float]:
    """Return the lower triangle of J J^T, and its trace."""
    products, trace = np.empty((len(rows), len(rows))), 0.0
    for i in range(len(rows)):
        for j in range(i + 1):
            products[i, j] = dot(rows[i], rows[j])
        trace += products[i, i]
    return products, trace


@compiled
def _factorize(gram: Floats) -> float:
    """Replace a Gram matrix's lower triangle (m, m) by L (Cholesky); return its determinant."""
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
def _solve(lower: Floats, solution: Floats) -> None:
    """Solve ``L L^T x = b`` for a triangular L (m, m) in place of b."""
    rows = len(lower)
    for i in range(rows):
        rest = solution[i]
        for k in range(i):
            rest -= lower[i, k] * solution[k]
        solution[i] = rest / lower[i, i]
    for i in range(rows - 1, -1, -1):
        rest = solution[i]
        for k in range(i + 1, rows):
            rest -= lower[k, i] * solution[k]
        solution[i] = rest / lower[i, i]


@compiled
def _volume_near_singularity(jacobian: Floats, gradient: Floats) -> float:
    """Return w from singular values; write minus its derivative by the Jacobian (m, n)."""
    rows, size = len(jacobian), 1.0
    turned, left, sizes = np.empty(jacobian.shape), np.eye(rows), np.empty(rows)
    for i in range(rows):
        copy(turned[i], jacobian[i], 1.0)
    jacobi_svd(turned, left)
    for i in range(rows):
        sizes[i] = norm(turned[i])
        size *= sizes[i]
        fill(gradient[i], 0.0)
    # Several vanishing values would keep each other down, so that each takes the others as larger.
    # That is still a direction in which all grow.
    direction, least = np.empty(jacobian.shape[1]), _LEAST * np.max(sizes)
    for i in range(rows):
        others, small = 1.0, (least if sizes[i] < least else 0.0)
        for k in range(rows):
            others *= max(sizes[k], small) if k != i else 1.0
        if others > 0.0:
            _right_vector(turned, sizes, i, direction)
            for row in range(rows):
                add(gradient[row], direction, -others * left[i, row])
    return size


@compiled
def _right_vector(turned: Floats, sizes: Floats, place: int, direction: Floats) -> None:
    """Write the right singular vector of one row, or a null vector if its value vanishes."""
    largest = 0.0
    for i in range(len(sizes)):
        largest = max(largest, sizes[i])
    if sizes[place] > 1e-12 * largest:
        copy(direction, turned[place], 1.0 / sizes[place])
        return
    vector, longest = np.empty(len(direction)), 0.0
    for axis in range(len(direction)):
        fill(vector, 0.0)
        vector[axis] = 1.0
        for _ in range(2):
            for row in range(len(turned)):
                if row != place and sizes[row] > 0.0:
                    add(vector, turned[row], -dot(vector, turned[row]) / sizes[row] ** 2)
        length = norm(vector)
        if length > longest:
            longest = length
            copy(direction, vector, 1.0 / length)

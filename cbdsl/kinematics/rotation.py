"""Rotation vectors as differences of orientations."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled, compiled_once


def exp(vector: Floats) -> Floats:
    """Return the rotation matrix (3, 3) of a rotation vector (3,), rad (Rodrigues)."""
    angle = math.hypot(*vector.tolist())
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (vector / angle).tolist()
    turn = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    versine = 2.0 * math.sin(0.5 * angle) ** 2  # 1 - cos, exact for small angles
    rotation: Floats = np.eye(3) + math.sin(angle) * turn + versine * (turn @ turn)
    return rotation


def log(rotation: Floats) -> Floats:
    """Return the rotation vector of a rotation matrix, SO(3) logarithm.

    Args:
        rotation: Rotation matrix, shape (3, 3).

    Returns:
        Axis times angle, rad, shape (3,), with an angle of at most pi.
    """
    vector = np.empty(3)
    log_between(np.eye(3).ravel(), rotation.ravel(), vector)
    return vector


@compiled_once
def log_between(rotation: Floats, wanted: Floats, vector: Floats) -> None:
    """Write the rotation vector, rad, world axes, shape (3,), between two rotations (9,).

    The largest of the four components of the turn's quaternion is computed first, and the others
    are divided by it. All angles, including those near pi, are therefore accurate (Shepperd 1978).
    """
    turn = _turn_between(rotation, wanted)
    products, trace = np.empty(4), turn[0, 0] + turn[1, 1] + turn[2, 2]
    largest = -1
    for i in range(3):
        if turn[i, i] > trace and (largest < 0 or turn[i, i] > turn[largest, largest]):
            largest = i
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if largest < 0 or i == largest:
            products[i + 1] = turn[k, j] - turn[j, k]
        else:
            products[i + 1] = turn[i, largest] + turn[largest, i]
    if largest < 0:
        products[0] = 1.0 + trace
    else:
        products[0] = products[largest + 1]
        products[largest + 1] = 1.0 + 2.0 * turn[largest, largest] - trace
    # A quaternion and its negative are the same turn; a scalar part above 0 gives at most pi.
    sign = 1.0 if products[0] >= 0.0 else -1.0
    norm = math.sqrt(products[0] ** 2 + products[1] ** 2 + products[2] ** 2 + products[3] ** 2)
    for i in range(3):
        vector[i] = sign * products[i + 1] / norm
    sine = math.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
    factor = 2.0 * math.atan2(sine, sign * products[0] / norm) / sine if sine > 0.0 else 2.0
    for i in range(3):
        vector[i] *= factor


@compiled
def _turn_between(rotation: Floats, wanted: Floats) -> Floats:
    """Return the matrix (3, 3) that turns one rotation into another."""
    turn = np.zeros((3, 3))
    for i in range(3):
        for k in range(3):
            for inner in range(3):
                turn[i, k] += wanted[3 * i + inner] * rotation[3 * k + inner]
    return turn


@compiled_once
def align(axis: Floats, wanted: Floats, fallback: Floats) -> Floats:
    """Return the shortest rotation that turns one unit vector onto another.

    Args:
        axis: Direction to turn, shape (3,).
        wanted: Desired direction, shape (3,).
        fallback: Unit vector at right angles to ``axis``, the axis of the turn if ``wanted`` is
            opposite and every such axis is as short.

    Returns:
        Rotation vector at right angles to ``axis``, rad, shape (3,).
    """
    cosine = axis[0] * wanted[0] + axis[1] * wanted[1] + axis[2] * wanted[2]
    # The nearer of the two sums is exact, so the product keeps its digits near 0 and pi.
    nearer, near, turn = 1.0 if cosine < 0 else -1.0, np.empty(3), np.empty(3)
    for i in range(3):
        near[i] = wanted[i] + nearer * axis[i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turn[i] = axis[j] * near[k] - axis[k] * near[j]
    sine = math.hypot(math.hypot(turn[0], turn[1]), turn[2])
    for i in range(3):
        if sine == 0.0:
            turn[i] = fallback[i] * (math.pi if cosine < 0 else 0.0)
        else:
            turn[i] *= math.atan2(sine, cosine) / sine
    return turn

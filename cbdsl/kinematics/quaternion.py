"""Unit quaternions, as (x, y, z, w)."""

from __future__ import annotations

import numpy as np

from cbdsl.numeric.arrays import Floats


def rotations(quaternions: Floats) -> Floats:
    """Return matrices, shape (..., 3, 3), of unit quaternions, shape (..., 4)."""
    single = quaternions.ndim == 1
    # Plain numbers take a tenth of the time for a single quaternion.
    x, y, z, w = quaternions.tolist() if single else np.moveaxis(quaternions, -1, 0)
    entries = (
        *(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        *(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        *(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    if single:
        return np.array(entries).reshape(3, 3)
    return np.stack(entries, axis=-1).reshape(*quaternions.shape[:-1], 3, 3)


def quaternion_of(rotation: Floats) -> tuple[float, float, float, float]:
    """Return the quaternion of a rotation matrix, shape (3, 3)."""
    m = rotation
    # Of the four formulas, the one with the largest divisor is numerically safe.
    divisors = np.array([1 + np.trace(m), *(1 - np.trace(m) + 2 * np.diag(m))])
    case = int(np.argmax(divisors))
    root = 2 * np.sqrt(divisors[case])
    skew = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    if case == 0:
        x, y, z = skew / root
        return float(x), float(y), float(z), float(root / 4)
    axis = case - 1
    vector = (m[axis] + m[:, axis]) / root
    vector[axis] = root / 4
    x, y, z = vector
    return float(x), float(y), float(z), float(skew[axis] / root)


def quaternion_about(axis: Floats, angle: float) -> Floats:
    """Return the quaternion of a rotation about a unit axis, shape (3,), by an angle, rad."""
    return np.append(np.sin(angle / 2) * axis, np.cos(angle / 2))


def product(first: Floats, second: Floats) -> Floats:
    """Return the product of two quaternions, the rotation by ``second`` followed by ``first``."""
    vector = first[3] * second[:3] + second[3] * first[:3] + np.cross(first[:3], second[:3])
    return np.array([*vector, first[3] * second[3] - first[:3] @ second[:3]])


def inverse(quaternion: Floats) -> Floats:
    """Return the inverse of a quaternion."""
    conjugate: Floats = quaternion * np.array([-1.0, -1.0, -1.0, 1.0])
    return conjugate


def turned(quaternion: Floats, vector: Floats) -> Floats:
    """Return a vector, shape (3,), rotated by a quaternion."""
    # With q = (u, w): v' = v + w t + u x t, where t = 2 u x v. This replaces two quaternion
    # products.
    twice = 2.0 * np.cross(quaternion[:3], vector)
    result: Floats = vector + quaternion[3] * twice + np.cross(quaternion[:3], twice)
    return result

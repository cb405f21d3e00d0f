"""Closest points of convex shapes: hulls of points, grown by a radius; compiled.

Source: Gilbert, Johnson and Keerthi (1988). Of all differences between points of two hulls, the one
nearest to the origin is found by a simplex of at most four of them. In every step, the corner that
lies furthest against the present difference joins the simplex, until none lies further. The corners
that do not carry its nearest point leave it.

coal, which Pinocchio installs, solves the same problem, and the tests compare with it. It is called
from Python alone, and a tick is one call of compiled code. With 80 near pairs, a tick takes their
distances up to seven times. For hulls of 8 to 32 points, coal takes 0.8 to 1.0 us a pair, and this
module 0.7 to 3.6 us, both called from Python.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import add, copy, dot, fill

# Steps after which the nearest point so far is taken; a few are enough as a rule.
_MOST = 40
# Part of the squared distance that a further step may still gain.
_EXACT = 1e-8
# Squared distance below which hulls overlap, m^2.
_TOUCHING = 1e-16
# Share of an edge's square below which it depends on others.
_SINGULAR = 1e-12


@compiled_once
def closest_points(points: Floats, one: Integers, other: Integers, ends: Floats) -> float:
    """Compute the closest points of two hulls.

    Args:
        points: Points of all hulls, m, shape (p, 3).
        one: First point of a hull, and the one after its last, shape (2,).
        other: The same of the other hull.
        ends: The closest point of either hull, shape (2, 3); if they overlap, a point of both, as
            far as it is known. The search begins with the given points, which may be any.

    Returns:
        Distance of the hulls, m; 0 if they overlap.
    """
    corners, chosen, room = np.empty((4, 3)), np.empty((4, 2), np.int64), np.empty((9, 4))
    shares, way, size, square = room[0], np.empty(3), 0, math.inf
    for axis in range(3):
        way[axis] = ends[0, axis] - ends[1, axis]
    for _ in range(_MOST):
        first, second = _farthest(points, one, way, -1.0), _farthest(points, other, way, 1.0)
        known = False
        for axis in range(3):
            corners[size, axis] = points[first, axis] - points[second, axis]
        for i in range(size):
            known |= chosen[i, 0] == first and chosen[i, 1] == second
        reach = dot(corners[size], way)
        if known or (size > 0 and square - reach <= _EXACT * square):
            break
        chosen[size, 0], chosen[size, 1] = first, second
        size = _reduce(corners, chosen, size + 1, room)
        _sum_up(corners, shares, size, way)
        square = dot(way, way)
        if size == 4 or square < _TOUCHING:
            square = 0.0
            break
    fill(ends[0], 0.0)
    fill(ends[1], 0.0)
    for i in range(size):
        add(ends[0], points[chosen[i, 0]], shares[i])
        add(ends[1], points[chosen[i, 1]], shares[i])
    return math.sqrt(square)


@compiled
def _sum_up(corners: Floats, shares: Floats, size: int, point: Floats) -> None:
    """Write the point of a simplex with some shares of its corners."""
    fill(point, 0.0)
    for i in range(size):
        add(point, corners[i], shares[i])


@compiled
def _farthest(points: Floats, hull: Integers, way: Floats, sign: float) -> int:
    """Return the point of a hull that lies furthest along a direction (3,) or against it."""
    farthest, most = int(hull[0]), -math.inf
    x, y, z = way[0], way[1], way[2]  # views of rows would take longer
    for i in range(hull[0], hull[1]):
        along = sign * (points[i, 0] * x + points[i, 1] * y + points[i, 2] * z)
        if along > most:
            farthest, most = i, along
    return farthest


@compiled
def _reduce(corners: Floats, chosen: Integers, size: int, room: Floats) -> int:
    """Keep the corners of a simplex that carry its point nearest to the origin.

    That point is inside of a part of the simplex with the newest corner, or of the whole.

    Args:
        corners: Corners, the newest one last, shape (4, 3).
        chosen: Points of both hulls that they are the differences of, shape (4, 2).
        size: Number of corners.
        room: Output: the share of each kept corner in the first row; the others are room, (9, 4).

    Returns:
        Number of kept corners; 4 if the simplex contains the origin.
    """
    shares, best = room[0], room[1]
    newest, least, kept = size - 1, math.inf, 0
    for part in range(1 << newest):
        square = _nearest(corners, part, newest, shares, room[2:])
        if square < least:
            least, kept = square, part
            copy(best, shares, 1.0)
    count = 0
    for i in range(size):
        if i == newest or kept >> i & 1:
            shares[count] = best[i]
            copy(corners[count], corners[i], 1.0)
            chosen[count, 0], chosen[count, 1] = chosen[i, 0], chosen[i, 1]
            count += 1
    return count


@compiled
def _nearest(corners: Floats, part: int, newest: int, shares: Floats, room: Floats) -> float:
    """Return the squared distance of a part of a simplex from the origin.

    Infinite if its nearest point is on its border, which other parts have. The newest corner
    belongs to the part, and each other one whose bit is set.
    """
    edges, gram, along, count = room[:3], room[3:6], room[6], 0
    for i in range(newest):
        if part >> i & 1:
            for axis in range(3):
                edges[count, axis] = corners[i, axis] - corners[newest, axis]
            along[count] = -dot(edges[count, :3], corners[newest])
            for j in range(count + 1):
                gram[count, j] = gram[j, count] = dot(edges[count, :3], edges[j, :3])
            count += 1
    if not _solve(gram, along, count):
        return math.inf
    rest = 1.0
    for i in range(count):
        rest -= along[i]
        if along[i] <= 0.0 or rest <= 0.0:
            return math.inf
    return _square(corners, part, newest, along, rest, shares)


@compiled
def _square(
    corners: Floats, part: int, newest: int, along: Floats, rest: float, shares: Floats
) -> float:
    """Write the shares of all corners, and return the squared length of their sum."""
    count, square = 0, 0.0
    for i in range(4):
        shares[i] = 0.0
        if i < newest and part >> i & 1:
            shares[i] = along[count]
            count += 1
    shares[newest] = rest
    for axis in range(3):
        total = 0.0
        for i in range(newest + 1):
            total += shares[i] * corners[i, axis]
        square += total * total
    return square


@compiled
def _solve(matrix: Floats, values: Floats, count: int) -> bool:
    """Solve for values (count,) by a symmetric matrix, in place; False if nearly singular."""
    for i in range(count):
        for j in range(i + 1, count):
            factor = matrix[j, i] / matrix[i, i] if matrix[i, i] > 0.0 else 0.0
            scale = matrix[j, j]
            add(matrix[j, i:count], matrix[i, i:count], -factor)
            values[j] -= factor * values[i]
            if matrix[j, j] <= _SINGULAR * scale and j == i + 1:
                return False
    if count > 0 and matrix[0, 0] <= 0.0:
        return False
    for i in range(count - 1, -1, -1):
        values[i] = (values[i] - dot(matrix[i, i + 1 : count], values[i + 1 : count])) / matrix[
            i, i
        ]
    return True

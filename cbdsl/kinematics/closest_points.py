"""Closest points of convex shapes: hulls of points, grown by a radius; compiled.

Source: Gilbert, Johnson and Keerthi (1988). Of all differences between points of two hulls, the one
nearest to the origin is found by a simplex of at most four of them. In every step, the corner that
lies furthest against the present difference joins the simplex, until none lies further. The corners
that do not carry its nearest point leave it. A search begins with the corners that carried the last
nearest point, as most still do a tick later.

coal, which Pinocchio installs, solves the same problem, and the tests compare with it. It is called
from Python alone, and a tick is one call of compiled code.
"""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import add, fill

# Steps after which the nearest point so far is taken; a few are enough as a rule.
_MOST = 40
# Part of the squared distance that a further step may still gain.
_EXACT = 1e-8
# Squared distance below which hulls overlap, m^2.
_TOUCHING = 1e-16
# Share of the product of edges below which their area or volume, squared, counts as none.
_SINGULAR = 1e-12
# Rows of the room of a search after four corners: the share of each, three edges from the newest
# corner, and the way from there to the origin.
_SHARES, _EDGES, _WAY = 4, 5, 8


@compiled_once
def closest_points(
    points: Floats, one: Integers, other: Integers, simplex: Integers, ends: Floats
) -> float:
    """Compute the closest points of two hulls.

    Args:
        points: Points of all hulls, m, shape (p, 3).
        one: First point of a hull, and the one after its last, shape (2,).
        other: The same of the other hull.
        simplex: Points of both hulls whose differences carry the nearest one, shape (4, 2); -1
            after the last. The search begins with them. They are -1 for hulls that overlap.
        ends: The closest point of either hull, shape (2, 3); if they overlap, a point of both, as
            far as it is known. The search begins with the given points, which may be any.

    Returns:
        Distance of the hulls, m; 0 if they overlap.
    """
    room, size, square = np.empty((9, 4)), 0, math.inf
    x, y, z = ends[0, 0] - ends[1, 0], ends[0, 1] - ends[1, 1], ends[0, 2] - ends[1, 2]
    while size < 3 and simplex[size, 0] >= 0:
        _subtract(points, simplex, size, room)
        size += 1
    if size > 0 and _carrier(room, size - 1) == (1 << size) - 1:
        x, y, z = _nearest(room, size)
        square = x * x + y * y + z * z
    else:
        size = 0
    for _ in range(_MOST):
        if square < _TOUCHING:
            break
        first, second = _farthest(points, one, -x, -y, -z), _farthest(points, other, x, y, z)
        known = False
        for i in range(size):
            known |= simplex[i, 0] == first and simplex[i, 1] == second
        simplex[size, 0], simplex[size, 1] = first, second
        _subtract(points, simplex, size, room)
        reach = x * room[size, 0] + y * room[size, 1] + z * room[size, 2]
        if known or (size > 0 and square - reach <= _EXACT * square):
            break
        size = _keep(room, simplex, size, _carrier(room, size))
        x, y, z = _nearest(room, size)
        square = x * x + y * y + z * z if size < 4 else 0.0
    fill(ends[0], 0.0)
    fill(ends[1], 0.0)
    for i in range(size):
        add(ends[0], points[simplex[i, 0]], room[_SHARES, i])
        add(ends[1], points[simplex[i, 1]], room[_SHARES, i])
    for i in range(size if square >= _TOUCHING else 0, 4):
        simplex[i, 0] = -1
    return math.sqrt(square) if square >= _TOUCHING else 0.0


@compiled
def _subtract(points: Floats, simplex: Integers, place: int, room: Floats) -> None:
    """Write a corner of a simplex, the difference of two points."""
    for axis in range(3):
        room[place, axis] = points[simplex[place, 0], axis] - points[simplex[place, 1], axis]


@compiled
def _nearest(room: Floats, size: int) -> tuple[float, float, float]:
    """Return the point of a simplex that the shares of its corners give."""
    x = y = z = 0.0
    for i in range(size):
        share = room[_SHARES, i]
        x, y, z = x + share * room[i, 0], y + share * room[i, 1], z + share * room[i, 2]
    return x, y, z


@compiled
def _farthest(points: Floats, hull: Integers, x: float, y: float, z: float) -> int:
    """Return the point of a hull that lies furthest along a direction."""
    farthest, most = int(hull[0]), -math.inf
    for i in range(hull[0], hull[1]):
        along = points[i, 0] * x + points[i, 1] * y + points[i, 2] * z
        if along > most:
            farthest, most = i, along
    return farthest


@compiled
def _keep(room: Floats, simplex: Integers, newest: int, part: int) -> int:
    """Keep a part of a simplex, a bit for each corner; return its size."""
    size = 0
    for i in range(newest + 1):
        if part >> i & 1:
            simplex[size, 0], simplex[size, 1] = simplex[i, 0], simplex[i, 1]
            room[_SHARES, size] = room[_SHARES, i]
            for axis in range(3):
                room[size, axis] = room[i, axis]
            size += 1
    return size


@compiled
def _carrier(room: Floats, newest: int) -> int:
    """Write the shares of the corners in a simplex' point nearest to the origin.

    That point is inside of a part of the simplex with the newest corner, or of the whole. The part
    has positive shares, and of all such parts the least distance.

    Args:
        room: Corners, shape (9, 4); shares, edges from the newest corner and their products are
            written.
        newest: Number of the newest corner, the last one.

    Returns:
        The part, a bit for each corner; all four if the simplex contains the origin.
    """
    for axis in range(3):
        room[_WAY, axis] = -room[newest, axis]
        for i in range(newest):
            room[_EDGES + i, axis] = room[i, axis] - room[newest, axis]
    part, most = 1 << newest, 0.0
    _share(room, newest, 0, 0.0, 0, 0.0)
    for i in range(newest):
        along, square = _dot(room, _EDGES + i, _WAY), _dot(room, _EDGES + i, _EDGES + i)
        room[_EDGES + i, 3], room[i, 3] = along, square
        if 0.0 < along < square and along * along > most * square:
            part, most = 1 << newest | 1 << i, along * along / square
            _share(room, newest, i, along / square, i, 0.0)
    for i in range(newest):
        for j in range(i):
            both = _dot(room, _EDGES + i, _EDGES + j)
            area = room[i, 3] * room[j, 3] - both * both
            if area > _SINGULAR * room[i, 3] * room[j, 3]:
                a, b = room[_EDGES + i, 3], room[_EDGES + j, 3]
                first, second = a * room[j, 3] - b * both, b * room[i, 3] - a * both
                first, second = first / area, second / area
                gain = a * first + b * second
                if first > 0.0 and second > 0.0 and first + second < 1.0 and gain > most:
                    part, most = 1 << newest | 1 << i | 1 << j, gain
                    _share(room, newest, i, first, j, second)
    return 15 if newest == 3 and _contains_origin(room) else part


@compiled
def _contains_origin(room: Floats) -> bool:
    """Return whether four corners contain the origin; write their shares if so."""
    volume = _volume(room, _EDGES, _EDGES + 1, _EDGES + 2)
    if volume * volume <= _SINGULAR * room[0, 3] * room[1, 3] * room[2, 3]:
        return False
    first = _volume(room, _WAY, _EDGES + 1, _EDGES + 2) / volume
    second = _volume(room, _EDGES, _WAY, _EDGES + 2) / volume
    third = _volume(room, _EDGES, _EDGES + 1, _WAY) / volume
    if min(first, second, third) <= 0.0 or first + second + third >= 1.0:
        return False
    _share(room, 3, 0, first, 1, second)
    room[_SHARES, 2] = third
    room[_SHARES, 3] -= third
    return True


@compiled
def _share(room: Floats, newest: int, i: int, first: float, j: int, second: float) -> None:
    """Write the shares of two corners, and leave the rest to the newest one."""
    for corner in range(4):
        room[_SHARES, corner] = 0.0
    room[_SHARES, j] = second
    room[_SHARES, i] = first
    room[_SHARES, newest] = 1.0 - first - second


@compiled
def _dot(room: Floats, i: int, j: int) -> float:
    """Return the scalar product of two rows; views of them would take longer."""
    product: float = room[i, 0] * room[j, 0] + room[i, 1] * room[j, 1] + room[i, 2] * room[j, 2]
    return product


@compiled
def _volume(room: Floats, i: int, j: int, k: int) -> float:
    """Return the triple product of three rows."""
    volume: float = (
        room[i, 0] * (room[j, 1] * room[k, 2] - room[j, 2] * room[k, 1])
        + room[i, 1] * (room[j, 2] * room[k, 0] - room[j, 0] * room[k, 2])
        + room[i, 2] * (room[j, 0] * room[k, 1] - room[j, 1] * room[k, 0])
    )
    return volume

"""Distances between links of a robot, and from obstacles, in a posture; compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cbdsl.kinematics.closest_points import closest_points
from cbdsl.kinematics.forward import place_joints, twist_of
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.handle import Handle
from cbdsl.numeric.vector import dot, fill

#: Convex shape of a link: its first point and the one after its last, the frame that carries it,
#: its radius, and a ball around all of it: centre in that frame, and radius.
SHAPE = np.dtype([
    ("span", np.int64, 2), ("frame", np.int64), ("radius", np.float64),
    ("centre", np.float64, 3), ("reach", np.float64),
])  # fmt: skip

#: Pair of shapes: their numbers; whether they are so near that the distance is exact, otherwise it
#: is a lower bound, from the last one and the motion since; the distance, m, and that before the
#: tick; the direction from the second to the first; the closest point of either, and the points
#: that carry them (see ``closest_points``); and whether the pair holds the motion back.
PAIR = np.dtype([
    ("first", np.int64), ("second", np.int64), ("near", np.bool_), ("distance", np.float64),
    ("before", np.float64), ("normal", np.float64, 3), ("ends", np.float64, (2, 3)),
    ("simplex", np.int64, (4, 2)), ("held", np.bool_),
])  # fmt: skip


class DistanceArrays(NamedTuple):
    """Shapes of a robot, pairs of them, and their distances in the last posture.

    Attributes:
        shapes: Shapes, shape (s,) of ``SHAPE``.
        offsets: Points of the shapes in the frames that carry them, m, shape (p, 3).
        points: The same in the world, m; those of shapes without a near pair are older.
        centres: Centres of the balls around the shapes in the world, m, shape (s, 3).
        turns: Axes of the frames that carry the shapes, row by row, shape (s, 9).
        pairs: Pairs, shape (m,) of ``PAIR``.
        moving, joints, frames, axes: Joint tree, as ``place_joints`` takes and writes them.
        bounds: Least distance, m; distance beyond it at which pairs are near, m; share of the rest
            of the way to the least distance by which a pair may approach in a tick; distance beyond
            it at which approaching ends, m.
        at: Positions of the actuated joints in that posture, rad or m, shape (n,); NaN before one.
    """

    shapes: Records
    offsets: Floats
    points: Floats
    centres: Floats
    turns: Floats
    pairs: Records
    moving: Integers
    joints: Records
    frames: Floats
    axes: Floats
    bounds: Floats
    at: Floats


@compiled_once
def measure_held(arrays: Handle, positions: Floats) -> None:
    """Compute the distances of all pairs, for calls from Python; see ``measure``."""
    held: DistanceArrays = arrays.held
    measure(held, positions)


@compiled
def measure(arrays: DistanceArrays, positions: Floats) -> None:
    """Compute the distances of all pairs in a posture.

    Args:
        arrays: Shapes and pairs; frames, points and pairs are updated.
        positions: Positions of the actuated joints, rad or m, shape (n,).
    """
    shapes, pairs, frames, known = arrays.shapes, arrays.pairs, arrays.frames, True
    for joint in range(len(positions)):
        known &= positions[joint] == arrays.at[joint]
        arrays.at[joint] = positions[joint]
    if known:
        return
    place_joints(positions, arrays.moving, arrays.joints, frames, arrays.axes)
    placed, far = np.zeros(len(shapes), np.bool_), arrays.bounds[0] + arrays.bounds[1]
    moved = np.empty(len(shapes))
    for number in range(len(shapes)):
        moved[number] = _move(number, arrays)
    for number in range(len(pairs)):
        pair = pairs[number]
        was_near, pair.near = pair.near, False
        pair.distance -= moved[pair.first] + moved[pair.second]
        if pair.distance <= far:
            for shape in (pair.first, pair.second):
                if not placed[shape]:
                    placed[shape] = True
                    _place(shapes[shape], arrays)
            # Most pairs are still apart in the direction in which they were.
            if not was_near:
                pair.distance = _gap(pair, arrays)
            if was_near or pair.distance <= far:
                _separate(pair, arrays)
            pair.near = pair.distance <= far


@compiled
def _move(number: int, arrays: DistanceArrays) -> float:
    """Move a shape to its new frame; return a bound on the way of all its points, m."""
    shape, turn, way = arrays.shapes[number], 0.0, 0.0
    frame, centres, turns, at = arrays.frames, arrays.centres, arrays.turns, shape.frame
    for i in range(9):
        turn += (frame[at, i] - turns[number, i]) ** 2
        turns[number, i] = frame[at, i]
    for axis in range(3):
        before, centre = centres[number, axis], frame[at, 9 + axis]
        for k in range(3):
            centre += frame[at, 3 * axis + k] * shape.centre[k]
        way += (centre - before) ** 2
        centres[number, axis] = centre
    # The norm of the turn's matrix is at most the root of the sum of its squares.
    bound: float = math.sqrt(way) + shape.reach * math.sqrt(turn)
    return bound


@compiled
def _place(shape: Any, arrays: DistanceArrays) -> None:
    """Write the points of a shape in the world."""
    frame, offsets, points, at = arrays.frames, arrays.offsets, arrays.points, shape.frame
    for axis in range(3):
        x, y, z = frame[at, 3 * axis], frame[at, 3 * axis + 1], frame[at, 3 * axis + 2]
        origin = frame[at, 9 + axis]
        for i in range(shape.span[0], shape.span[1]):
            points[i, axis] = origin + x * offsets[i, 0] + y * offsets[i, 1] + z * offsets[i, 2]


@compiled
def _gap(pair: Any, arrays: DistanceArrays) -> float:
    """Return the gap between both shapes along the direction of a pair, at most their distance."""
    first, second = arrays.shapes[pair.first], arrays.shapes[pair.second]
    least, most = math.inf, -math.inf
    points, x, y, z = arrays.points, pair.normal[0], pair.normal[1], pair.normal[2]
    for k in range(first.span[0], first.span[1]):
        least = min(least, points[k, 0] * x + points[k, 1] * y + points[k, 2] * z)
    for k in range(second.span[0], second.span[1]):
        most = max(most, points[k, 0] * x + points[k, 1] * y + points[k, 2] * z)
    gap: float = least - most - first.radius - second.radius
    return gap


@compiled
def _separate(pair: Any, arrays: DistanceArrays) -> None:
    """Write the distance, direction and closest points of a pair."""
    first, second = arrays.shapes[pair.first], arrays.shapes[pair.second]
    inner = closest_points(arrays.points, first.span, second.span, pair.simplex, pair.ends)
    pair.distance = inner - first.radius - second.radius
    length = 0.0
    for axis in range(3):
        # Overlapping hulls have no direction of their own; their middles part them.
        pair.normal[axis] = (
            pair.ends[0, axis] - pair.ends[1, axis]
            if inner > 0.0
            else arrays.centres[pair.first, axis] - arrays.centres[pair.second, axis]
        )
        length += pair.normal[axis] ** 2
    for axis in range(3):
        pair.normal[axis] /= math.sqrt(length) + 1e-300


@compiled_once
def write_slope_held(arrays: Handle, number: int, row: Floats) -> None:
    """Write the slope of a pair's distance, for calls from Python; see ``write_slope``."""
    held: DistanceArrays = arrays.held
    write_slope(held, number, row)


@compiled
def write_slope(arrays: DistanceArrays, number: int, row: Floats) -> None:
    """Write the change of a near pair's distance per joint.

    Args:
        arrays: Shapes and pairs, as ``measure`` left them.
        number: Number of the pair.
        row: Output: shape (n,).
    """
    pair, twist = arrays.pairs[number], np.empty(6)
    one, other = arrays.shapes[pair.first].frame, arrays.shapes[pair.second].frame
    fill(row, 0.0)
    # Parents have smaller numbers. Joints that carry both shapes leave their distance as it is.
    while one != other:
        end, frame = (0, one) if one > other else (1, other)
        joint = arrays.joints[frame - 1]
        twist_of(pair.ends[end], frame - 1, arrays.joints, arrays.frames, arrays.axes, twist)
        row[joint.column] += (1.0 - 2.0 * end) * dot(pair.normal, twist[:3])
        one, other = (joint.parent, other) if end == 0 else (one, joint.parent)

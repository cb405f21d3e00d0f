"""Forward kinematics of a joint tree, and Jacobians of its points (Eq 3.11 to 3.13); compiled."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import copy, cross, fill

#: A moving joint, parents first: its parent frame, its column among the actuated joints and its
#: ratio to that joint, its placement in the parent's frame, its axis there, and whether it is
#: prismatic.
JOINT = np.dtype(
    [
        ("parent", np.int64),
        ("column", np.int64),
        ("ratio", np.float64),
        ("rotation", np.float64, 9),
        ("origin", np.float64, 3),
        ("axis", np.float64, 3),
        ("slides", np.bool_),
    ]
)


@compiled_once
def place_joints(
    positions: Floats, moving: Integers, joints: Records, frames: Floats, axes: Floats
) -> None:
    """Compute the frames of moving joints in the world.

    Args:
        positions: Positions of the actuated joints, rad or m, shape (n,).
        moving: Numbers of the joints to place, parents first, shape (m,).
        joints: Joint tree, shape (j,) of ``JOINT``.
        frames: Output: frame of the base, then of each joint: rotation row by row, then origin, m,
            shape (j + 1, 12).
        axes: Output: axis of each joint in the world frame, shape (j, 3).
    """
    # With the parent's frame (R, o), the placement (R0, o0), the axis a and the position q of a
    # joint:
    #     turning:  R' = R R0 Rot(a, q),   o' = o + R o0
    #     sliding:  R' = R R0,             o' = o + R o0 + q R R0 a
    # The order of ``moving`` guarantees that each parent's frame is up to date.
    turn, turned = np.empty(9), np.empty(9)
    for j in moving:
        joint = joints[j]
        parent, own, axis = frames[joint.parent], frames[j + 1], joint.axis
        multiply(parent, joint.rotation, turned)
        for i in range(3):
            own[9 + i] = parent[9 + i]
            axes[j, i] = 0.0
            for k in range(3):
                own[9 + i] += parent[3 * i + k] * joint.origin[k]
                axes[j, i] += turned[3 * i + k] * axis[k]
        value = joint.ratio * positions[joint.column]
        if joint.slides:
            for i in range(3):
                own[9 + i] += value * axes[j, i]
            copy(own[:9], turned, 1.0)
        else:
            rotate(axis, value, turn)
            multiply(turned, turn, own)


@compiled
def multiply(left: Floats, right: Floats, product: Floats) -> None:
    """Multiply two matrices (3, 3), row by row."""
    for i in range(3):
        for k in range(3):
            product[3 * i + k] = (
                left[3 * i] * right[k]
                + left[3 * i + 1] * right[3 + k]
                + left[3 * i + 2] * right[6 + k]
            )


@compiled
def rotate(axis: Floats, angle: float, turn: Floats) -> None:
    """Write the rotation matrix, row by row, of an angle, rad, about a unit axis (Rodrigues)."""
    x, y, z = axis[0], axis[1], axis[2]
    sine, cosine = math.sin(angle), math.cos(angle)
    versine = 1.0 - cosine
    turn[0], turn[4], turn[8] = (
        cosine + versine * x * x,
        cosine + versine * y * y,
        cosine + versine * z * z,
    )
    turn[1], turn[3] = versine * x * y - sine * z, versine * x * y + sine * z
    turn[2], turn[6] = versine * x * z + sine * y, versine * x * z - sine * y
    turn[5], turn[7] = versine * y * z - sine * x, versine * y * z + sine * x


@compiled_once
def rotation_of(vector: Floats) -> Floats:
    """Return the rotation matrix (3, 3) of a rotation vector (3,): axis times angle, rad."""
    turn = np.zeros(9)
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle == 0.0:
        turn[0] = turn[4] = turn[8] = 1.0
    else:
        rotate(vector / angle, angle, turn)
    return turn.reshape(3, 3)


@compiled_once
def place_point(frame: Floats, offset: Floats, point: Floats) -> None:
    """Write the world position, m, shape (3,), of a point with an offset (3,) in a frame (12,)."""
    for i in range(3):
        point[i] = frame[9 + i]
        for k in range(3):
            point[i] += frame[3 * i + k] * offset[k]


@compiled_once
def place_points(frames: Floats, numbers: Integers, offsets: Floats, points: Floats) -> None:
    """Write the world positions (k, 3) of points from their frames and offsets."""
    for place in range(len(numbers)):
        place_point(frames[numbers[place]], offsets[place], points[place])


@compiled_once
def place_link(
    frame: Floats, origin: Floats, axes: Floats, position: Floats, rotation: Floats
) -> None:
    """Write the placement of a link in the world frame.

    Args:
        frame: Frame that carries the link, shape (12,).
        origin: Origin of the link in that frame, m, shape (3,).
        axes: Axes of the link in that frame, as columns, shape (3, 3).
        position: Output: origin of the link, m, world frame, shape (3,).
        rotation: Output: axes of the link, world frame, as columns, shape (3, 3).
    """
    place_point(frame, origin, position)
    for i in range(3):
        for k in range(3):
            rotation[i, k] = 0.0
            for inner in range(3):
                rotation[i, k] += frame[3 * i + inner] * axes[inner, k]


@compiled_once
def place_links(
    frames: Floats,
    numbers: Integers,
    origins: Floats,
    axes: Floats,
    positions: Floats,
    rotations: Floats,
) -> None:
    """Write the placements of k links in the world frame; see ``place_link``."""
    for place in range(len(numbers)):
        frame = frames[numbers[place]]
        place_link(frame, origins[place], axes[place], positions[place], rotations[place])


@compiled_once
def turn_link(
    frame: Floats, axes: Floats, support: Integers, joints: Records, turned: Floats, turning: Floats
) -> None:
    """Compute the angular velocity of a link per joint velocity.

    Args:
        frame: Frame that carries the link, shape (12,).
        axes: Axes of the link in that frame, as columns, shape (3, 3).
        support: Joints that move the link, shape (k,).
        joints: Joint tree, as in ``place_joints``.
        turned: Joint axes in the world frame, shape (j, 3).
        turning: Output: velocity in the link's own axes, shape (3, n); zeros on entry.
    """
    own = np.empty((3, 3))
    for i in range(3):
        for k in range(3):
            own[i, k] = 0.0
            for inner in range(3):
                own[i, k] += frame[3 * i + inner] * axes[inner, k]
    for joint in support:
        if joints[joint].slides:
            continue
        column, ratio = joints[joint].column, joints[joint].ratio
        for k in range(3):
            for i in range(3):
                turning[k, column] += own[i, k] * (ratio * turned[joint, i])


@compiled
def twist_of(
    point: Floats, joint: int, joints: Records, frames: Floats, axes: Floats, twist: Floats
) -> None:
    """Write the linear above angular velocity (6,) of a point (3,) per velocity of an actuator."""
    ratio = joints[joint].ratio
    x, y, z = ratio * axes[joint, 0], ratio * axes[joint, 1], ratio * axes[joint, 2]
    if joints[joint].slides:
        twist[0], twist[1], twist[2] = x, y, z
        fill(twist[3:], 0.0)
        return
    own = frames[joint + 1]
    a, b, c = point[0] - own[9], point[1] - own[10], point[2] - own[11]
    twist[0], twist[1], twist[2] = y * c - z * b, z * a - x * c, x * b - y * a
    twist[3], twist[4], twist[5] = x, y, z


@compiled_once
def move_point(
    point: Floats,
    support: Integers,
    joints: Records,
    frames: Floats,
    axes: Floats,
    jacobian: Floats,
) -> None:
    """Add a point's motion to a Jacobian.

    Args:
        point: Point, world frame, m, shape (3,).
        support: Joints that move the point, shape (k,).
        joints, frames, axes: Joint tree, frames and axes, as in ``place_joints``.
        jacobian: Jacobian to which the point's velocity per velocity of the actuated joints is
            added: linear above angular, world axes, shape (6, n), or linear, shape (3, n).
    """
    twist = np.empty(6)
    for joint in support:
        twist_of(point, joint, joints, frames, axes, twist)
        column = joints[joint].column
        # Passive joints share the column of the joint that they follow, so that motions add up.
        for row in range(len(jacobian)):
            jacobian[row, column] += twist[row]


@compiled_once
def bend_point(
    point: Floats,
    support: Integers,
    joints: Records,
    frames: Floats,
    axes: Floats,
    curvature: Floats,
) -> None:
    """Add the derivative of a point's Jacobian by the joint positions.

    A joint turns the axes and levers of the joints beyond it, and moves the point as it turns those
    of the joints before it. For joints i before j, the column of either changes by the other as
    omega_i x v_j. Their axes change as omega_i x omega_j, by joint i alone.

    Args:
        point, support, joints, frames, axes: Arguments as in ``move_point``.
        curvature: Derivative to add to, shape (rows, n, n), with 3 rows for the linear part alone
            or 6 for both. The change of the Jacobian's entry (k, i) per joint j is added to entry
            (k, i, j).
    """
    first, second, change = np.empty(6), np.empty(6), np.empty(3)
    for i in range(len(support)):
        twist_of(point, support[i], joints, frames, axes, first)
        one = joints[support[i]].column
        for j in range(i, len(support)):
            twist_of(point, support[j], joints, frames, axes, second)
            other = joints[support[j]].column
            cross(first[3:], second[:3], change)
            for row in range(3):
                curvature[row, other, one] += change[row]
                if i != j:
                    curvature[row, one, other] += change[row]
            if len(curvature) == 6:
                cross(first[3:], second[3:], change)
                for row in range(3):
                    curvature[3 + row, other, one] += change[row]

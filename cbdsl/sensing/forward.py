"""Forward kinematics of a tree of joints, and how its points move (Eq 3.11 to 3.13); compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.vector import copy, cross, fill

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Records = NDArray[Any]

#: A moving joint, parents first: the frame it moves in, its column among the actuated joints and
#: how far it follows that one, its placement in the parent's frame, its axis there, and whether it
#: slides.
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
        positions: of the actuated joints, rad or m, shape (n,).
        moving: which joints, parents first, shape (m,).
        joints: the tree, shape (j,) of ``JOINT``.
        frames: becomes each joint's frame behind the base's own: its rotation row by row, then its
            origin, m, shape (j + 1, 12).
        axes: becomes each joint's axis in the world, shape (j, 3).
    """
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
    """The rotation matrix, row by row, of an angle, rad, about a unit axis (Rodrigues)."""
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
    """The rotation matrix (3, 3) of a rotation vector (3,): its axis times its angle, rad."""
    turn = np.zeros(9)
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle == 0.0:
        turn[0] = turn[4] = turn[8] = 1.0
    else:
        rotate(vector / angle, angle, turn)
    return turn.reshape(3, 3)


@compiled_once
def place_point(frame: Floats, offset: Floats, point: Floats) -> None:
    """Compute where a point, ``offset`` (3,) in a frame (12,), is in the world, m, shape (3,)."""
    for i in range(3):
        point[i] = frame[9 + i]
        for k in range(3):
            point[i] += frame[3 * i + k] * offset[k]


@compiled_once
def place_points(frames: Floats, numbers: Integers, offsets: Floats, points: Floats) -> None:
    """Compute where points (k, 3) are in the world, by their frames and offsets there."""
    for place in range(len(numbers)):
        place_point(frames[numbers[place]], offsets[place], points[place])


@compiled_once
def place_link(
    frame: Floats, origin: Floats, axes: Floats, position: Floats, rotation: Floats
) -> None:
    """Compute where a link is in the world.

    Args:
        frame: that carries it, shape (12,).
        origin: of the link in that frame, m, shape (3,).
        axes: of the link in that frame, as columns, shape (3, 3).
        position: becomes its origin, m, shape (3,).
        rotation: becomes its axes, as columns, shape (3, 3).
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
    """Compute where k links are in the world; see ``place_link``."""
    for place in range(len(numbers)):
        frame = frames[numbers[place]]
        place_link(frame, origins[place], axes[place], positions[place], rotations[place])


@compiled_once
def turn_link(
    frame: Floats, axes: Floats, support: Integers, joints: Records, turned: Floats, turning: Floats
) -> None:
    """Compute the angular velocity of a link per joint velocity.

    Args:
        frame: that carries it, shape (12,).
        axes: of the link in that frame, as columns, shape (3, 3).
        support: the joints that move it, shape (k,).
        joints: as of ``place_joints``.
        turned: the joints' axes in the world, shape (j, 3).
        turning: becomes the velocity in the link's own axes, shape (3, n); zeros before.
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
    """Linear above angular velocity (6,) of a point (3,) per velocity of the joint's actuator."""
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
        point: world frame, m, shape (3,).
        support: the joints that move it, shape (k,).
        joints, frames, axes: as of ``place_joints``.
        jacobian: becomes larger by the point's linear above angular velocity, world axes, per
            velocity of the actuated joints, shape (6, n), or its linear one, shape (3, n).
    """
    twist = np.empty(6)
    for joint in support:
        twist_of(point, joint, joints, frames, axes, twist)
        column = joints[joint].column
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
    """Add the derivative of a point's Jacobian, as it moves along with the joints.

    A joint turns the axes and levers of the joints beyond it, and moves the point as it turns
    those before it: of joints i before j, the column of either changes by the other as
    omega_i x v_j; their axes change as omega_i x omega_j, by joint i alone.

    Args:
        point, support, joints, frames, axes: as of ``move_point``.
        curvature: shape (rows, n, n), of 3 rows for the linear part alone or 6 for both; entry
            (k, i, j) grows by the change of the Jacobian's entry (k, i) per joint j.
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

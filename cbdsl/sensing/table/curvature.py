"""Derivatives of the Jacobians of rows by the joint positions; compiled.

Model. A joint i before joint j of the same chain turns the lever and the axis of j: the velocity
v_j of a point changes by w_i x v_j, and the axis w_j by w_i x w_j. A heading is that of a direction
d = R' s in the axes R of a camera, for a distant point: its Jacobian is N(angles) W, with the
camera's own axes W_j = R' w_j. For i before j, N W_i changes per joint j by dN(J_j) W_i + N (W_i x
W_j). A contact force is that of springs of a constant stiffness at the fingertips, whose points
bend as those of tips do. Assumptions: constant are the direction in which a palm presses, torques,
and the part of a heading that follows from the motion of a held object.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cbdsl.kinematics.forward import bend_point, multiply, place_point, twist_of
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled
from cbdsl.numeric.vector import cross
from cbdsl.sensing.signal_arrays import TableArrays, TreeArrays
from cbdsl.sensing.table.refresh import CONTACT, HEADING, MIXTURE, TIP, stand_off

#: Kinds of rows whose Jacobians change with the joint positions.
BENDING = (TIP, MIXTURE, HEADING, CONTACT)


@compiled
def bend_row(row: Any, table: TableArrays, tree: TreeArrays, bends: Floats) -> None:
    """Add the change of a row's Jacobian per joint.

    Args:
        row: Row of the signal table, of one of the kinds ``BENDING``.
        table, tree: Signal table and joint tree.
        bends: Sum so far, shape (rows, n, n). The change of the Jacobian's entry (k, i) per joint j
            is added to entry (k, i, j).
    """
    if row.kind == TIP:
        _bend_tip(row, table, tree, 1.0, bends)
    elif row.kind == MIXTURE:
        _bend_mixture(row, table, tree, bends)
    elif row.kind == HEADING:
        _bend_heading(row, table, tree, bends)
    elif row.kind == CONTACT:
        _bend_contact(row, table, tree, bends)


@compiled
def _bend_tip(row: Any, table: TableArrays, tree: TreeArrays, weight: float, bends: Floats) -> None:
    """Add the weighted change of a tip's Jacobian per joint, shape (rows, n, n)."""
    part, joints = table.parts[row.part], bends.shape[1]
    origin, point = np.empty(3), np.empty(3)
    stand_off(row, table.records, part, origin)
    place_point(tree.frames[part.frame], origin, point)
    change = np.zeros((6, joints, joints))
    own = table.support[part.support : part.support + part.joints]
    bend_point(point, own, tree.joints, tree.frames, tree.axes, change)
    first = 0 if row.linear else 3
    for i in range(len(bends)):
        for j in range(joints):
            for k in range(joints):
                bends[i, j, k] += weight * change[first + i, j, k]


@compiled
def _bend_mixture(row: Any, table: TableArrays, tree: TreeArrays, bends: Floats) -> None:
    """Write the change of a weighted sum of tips, for those parts that are tips."""
    for number in range(row.part, row.part + row.parts):
        part = table.parts[number]
        source = table.records[part.source]
        if source.kind == TIP:
            own = bends[part.shift : part.shift + source.rows]
            _bend_tip(source, table, tree, part.weight, own)


@compiled
def _bend_heading(row: Any, table: TableArrays, tree: TreeArrays, bends: Floats) -> None:
    """Add the weighted change of the headings in all cameras that see the target."""
    joints = bends.shape[1]
    for number in range(row.part, row.part + row.parts):
        part = table.parts[number]
        if part.weight == 0.0:
            continue
        own = table.support[part.support : part.support + part.joints]
        turns = np.empty((len(own), 3))
        _turn_camera(part, own, tree, turns)
        bend = np.zeros((2, joints, joints))
        _bend_direction(part.angles, own, turns, tree.joints, bend)
        for i in range(2):
            for j in range(joints):
                for k in range(joints):
                    bends[part.shift + i, j, k] += part.weight * bend[i, j, k]


@compiled
def _turn_camera(part: Any, own: Integers, tree: TreeArrays, turns: Floats) -> None:
    """Write the angular velocity of a camera in its own axes per joint, shape (joints, 3)."""
    camera, twist = np.empty(9), np.empty(6)
    multiply(tree.frames[part.frame], part.rotation, camera)
    for i in range(len(own)):
        center = tree.frames[part.frame, 9:]
        twist_of(center, own[i], tree.joints, tree.frames, tree.axes, twist)
        for row in range(3):
            turns[i, row] = 0.0
            for k in range(3):
                turns[i, row] += camera[3 * k + row] * twist[3 + k]


@compiled
def _bend_direction(
    angles: Floats, own: Integers, turns: Floats, joints: Records, bend: Floats
) -> None:
    """Add the change per joint of the Jacobian of a distant point's heading, shape (2, n, n)."""
    sine, cosine = math.sin(angles[0]), math.cos(angles[0])
    tangent, change = math.tan(angles[1]), np.empty(3)
    for j in range(len(own)):
        last = turns[j]
        # Change of both angles.
        sideways = tangent * (cosine * last[0] + sine * last[1]) - last[2]
        upwards = cosine * last[1] - sine * last[0]
        steeper = (1.0 + tangent * tangent) * upwards
        other = joints[own[j]].column
        for i in range(j + 1):
            first, one = turns[i], joints[own[i]].column
            cross(first, last, change)
            along = cosine * first[0] + sine * first[1]
            across = cosine * first[1] - sine * first[0]
            azimuth = steeper * along + tangent * sideways * across
            azimuth += tangent * (cosine * change[0] + sine * change[1]) - change[2]
            elevation = -sideways * along + cosine * change[1] - sine * change[0]
            bend[0, one, other] += azimuth
            bend[1, one, other] += elevation
            if i != j:
                bend[0, other, one] += azimuth
                bend[1, other, one] += elevation


@compiled
def _bend_contact(row: Any, table: TableArrays, tree: TreeArrays, bends: Floats) -> None:
    """Add the change of forces at fingertips, in all axes of the world or along a palm's normal."""
    joints, point = bends.shape[1], np.empty(3)
    for number in range(row.part, row.part + row.parts):
        part = table.parts[number]
        place_point(tree.frames[part.frame], part.origin, point)
        own = table.support[part.support : part.support + part.joints]
        change = np.zeros((3, joints, joints))
        bend_point(point, own, tree.joints, tree.frames, tree.axes, change)
        for k in range(3):
            place, weight = part.shift + k, part.weight
            if part.guide >= 0:
                place, turned = part.shift, 0.0
                for inner in range(3):
                    turned += tree.frames[part.guide, 3 * k + inner] * part.normal[inner]
                weight *= turned
            for i in range(joints):
                for j in range(joints):
                    bends[place, i, j] += weight * change[k, i, j]


@compiled
def bend_carried(rows: Floats, tree: TreeArrays, bends: Floats) -> None:
    """Write the change of the Jacobian (3, n) of a point that moves with the last of its joints."""
    # The point has no link of its own, so that its velocities come from the rows. A joint turns the
    # velocities due to itself and to the joints beyond it: from each joint, the inner loop goes
    # through its ancestors.
    joints, turn, change = tree.joints, np.empty(3), np.empty(3)
    for last in range(len(joints)):
        column = joints[last].column
        if column < 0 or joints[last].ratio == 0.0:
            continue
        velocity = rows[:, column].copy()
        if velocity[0] == 0.0 and velocity[1] == 0.0 and velocity[2] == 0.0:
            continue
        joint = last
        while joint >= 0:
            other = joints[joint].column
            if not joints[joint].slides and other >= 0:
                for i in range(3):
                    turn[i] = joints[joint].ratio * tree.axes[joint, i]
                cross(turn, velocity, change)
                for i in range(3):
                    bends[i, other, column] += change[i]
                    if joint != last:
                        bends[i, column, other] += change[i]
            joint = joints[joint].parent - 1

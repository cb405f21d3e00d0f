"""Rows of the signal table that follow from the posture and the load cells; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from cbdsl.kinematics.forward import multiply, place_point, twist_of
from cbdsl.numeric.arrays import Floats, Integers, Records
from cbdsl.numeric.compiled import compiled, compiled_once
from cbdsl.numeric.handle import Handle
from cbdsl.numeric.vector import add, cross, fill, norm
from cbdsl.sensing.signal_arrays import SensedArrays, SignalArrays, TableArrays, TreeArrays

#: Kinds of rows by the source of their numbers: written by Python; joint positions; a tip; the
#: Jacobian of tips; a weighted sum of other rows; the forces along the normals of load cells; a row
#: displaced by another; headings and contact forces, which Python writes, too, and whose parts say
#: how they bend; the length of another row's vector.
(
    WRITTEN, CONFIGURATION, TIP, MANIPULATOR, MIXTURE, NORMAL_FORCES, DISPLACED, HEADING, CONTACT,
    LENGTH,
) = range(10)  # fmt: skip

#: Kinds of rows that Python writes.
READ = (WRITTEN, HEADING, CONTACT)

#: States of a row: undefined; readable without a measurement, such as a force without contact;
#: measured.
UNDEFINED, READABLE, DEFINED = range(3)

#: A resource: its kind, the start and number of its value's components and of its Jacobian's rows,
#: its parts, whether linear and angular motion are included, the start and number of its columns,
#: its state, the stamp of the newest measurement, and the radius of the seen object.
#: A tip's control point may stand off along its z axis by the radius of another row and a
#: clearance.
ROW = np.dtype(
    [
        ("kind", np.int64),
        ("start", np.int64),
        ("size", np.int64),
        ("row", np.int64),
        ("rows", np.int64),
        ("part", np.int64),
        ("parts", np.int64),
        ("linear", np.bool_),
        ("angular", np.bool_),
        ("column", np.int64),
        ("columns", np.int64),
        ("defined", np.int64),
        ("stamp", np.int64),
        ("radius", np.float64),
        ("facing", np.int64),
        ("standoff", np.float64, 3),
    ]
)

#: A part of a row: a place in a frame, with the joints that move it; another row, with its weight
#: and its place in the sum; a load cell, with its normal in the frame, the radius of its fingertip,
#: and the first cell of the same joint; a camera, with the share of its heading and the heading,
#: rad; or a fingertip in contact, with its stiffness, N/m, and the frame of the only direction that
#: counts, -1 for all.
PART = np.dtype(
    [
        ("frame", np.int64),
        ("origin", np.float64, 3),
        ("rotation", np.float64, 9),
        ("support", np.int64),
        ("joints", np.int64),
        ("source", np.int64),
        ("weight", np.float64),
        ("shift", np.int64),
        ("cell", np.int64),
        ("normal", np.float64, 3),
        ("guide", np.int64),
        ("angles", np.float64, 2),
        ("radius", np.float64),
    ]
)


@compiled_once
def refresh(signals: Handle, needed: Integers, stamp: int) -> None:
    """Write rows of the signal table, for calls from Python; see ``write_rows``."""
    write_rows(signals.held, needed, stamp)


@compiled
def write_rows(signals: SignalArrays, needed: Integers, stamp: int) -> None:
    """Write rows of the signal table.

    Args:
        signals: Arrays of the signals.
        needed: Numbers of the rows to write, dependencies first, shape (r,).
        stamp: Number of the posture.
    """
    sensed, table, tree = signals.sensed, signals.table, signals.tree
    for place in range(len(needed)):
        row = table.records[needed[place]]
        row.stamp, row.defined = stamp, DEFINED
        if row.kind == CONFIGURATION:
            for i in range(row.columns):
                table.value[row.start + i] = sensed.positions[table.support[row.column + i]]
        elif row.kind == TIP:
            _write_tip(row, table, tree)
        elif row.kind == MANIPULATOR:
            _write_manipulator(row, table, tree)
        elif row.kind == MIXTURE:
            _write_mixture(row, table)
        elif row.kind == NORMAL_FORCES:
            _write_forces(row, table, sensed, tree.frames)
        elif row.kind == DISPLACED:
            _write_displaced(row, table)
        elif row.kind == LENGTH:
            _write_length(row, table)


@compiled
def _write_tip(row: Any, table: TableArrays, tree: TreeArrays) -> None:
    """Write a control point's position, rotation row by row, or both, and its Jacobian."""
    part, value, jacobian = table.parts[row.part], table.value, table.jacobian
    frame, turned = tree.frames[part.frame], part.rotation
    origin, point, twist = np.empty(3), np.empty(3), np.empty(6)
    stand_off(row, table.records, part, origin)
    place_point(frame, origin, point)
    start = row.start
    if row.linear:
        for i in range(3):
            value[start + i] = point[i]
        start += 3
    if row.angular:
        multiply(frame, turned, value[start : start + 9])
    first = 0 if row.linear else 3
    for i in range(row.rows):
        fill(jacobian[row.row + i], 0.0)
    for number in range(part.support, part.support + part.joints):
        joint = table.support[number]
        twist_of(point, joint, tree.joints, tree.frames, tree.axes, twist)
        column = tree.joints[joint].column
        for i in range(row.rows):
            jacobian[row.row + i, column] += twist[first + i]


@compiled
def stand_off(row: Any, records: Records, part: Any, origin: Floats) -> None:
    """Write the position of a tip's control point in its frame, m, shape (3,)."""
    along = 0.0
    if row.facing >= 0:
        clearance, least, most = row.standoff[0], row.standoff[1], row.standoff[2]
        along = min(max(records[row.facing].radius + clearance, least), most)
    for i in range(3):
        origin[i] = part.origin[i] + along * part.rotation[3 * i + 2]


@compiled
def _write_manipulator(row: Any, table: TableArrays, tree: TreeArrays) -> None:
    """Write the Jacobian of tips by some columns, row by row, and its derivative (Eq 3.5)."""
    support, value, jacobian = table.support, table.value, table.jacobian
    width, columns = row.columns, support[row.column : row.column + row.columns]
    fill(value[row.start : row.start + row.size], 0.0)
    for i in range(row.rows):
        fill(jacobian[row.row + i], 0.0)
    # These are the sums of ``forward.bend_point``, for the chosen columns of the Jacobian alone.
    height = 6 if row.angular else 3
    first, second, change, point = np.empty(6), np.empty(6), np.empty(3), np.empty(3)
    for number in range(row.parts):
        part = table.parts[row.part + number]
        own = support[part.support : part.support + part.joints]
        place_point(tree.frames[part.frame], part.origin, point)
        for i in range(len(own)):
            twist_of(point, own[i], tree.joints, tree.frames, tree.axes, first)
            one = tree.joints[own[i]].column
            here = _place(columns, one)
            for k in range(height):
                if here >= 0:
                    value[row.start + (number * height + k) * width + here] += first[k]
            for j in range(i, len(own)):
                twist_of(point, own[j], tree.joints, tree.frames, tree.axes, second)
                other = tree.joints[own[j]].column
                there = _place(columns, other)
                cross(first[3:], second[:3], change)
                block = row.row + number * height * width
                _bend(jacobian, block, width, there, one, change)
                if i != j:
                    _bend(jacobian, block, width, here, other, change)
                if height == 6:
                    cross(first[3:], second[3:], change)
                    _bend(jacobian, block + 3 * width, width, there, one, change)


@compiled
def _bend(
    jacobian: Floats, block: int, width: int, place: int, column: int, change: Floats
) -> None:
    """Add a column's change per joint to three rows of a manipulator Jacobian's derivative."""
    if place >= 0:
        for k in range(3):
            jacobian[block + k * width + place, column] += change[k]


@compiled
def _place(columns: Integers, column: int) -> int:
    for i in range(len(columns)):
        if columns[i] == column:
            return i
    return -1


@compiled
def _write_mixture(row: Any, table: TableArrays) -> None:
    """Write the weighted sum of other rows, which is defined if all of them are."""
    value, jacobian = table.value, table.jacobian
    fill(value[row.start : row.start + row.size], 0.0)
    for i in range(row.rows):
        fill(jacobian[row.row + i], 0.0)
    for number in range(row.part, row.part + row.parts):
        part = table.parts[number]
        source = table.records[part.source]
        row.defined = min(row.defined, source.defined)
        for i in range(source.size):
            value[row.start + part.shift + i] += part.weight * value[source.start + i]
        for i in range(source.rows):
            add(jacobian[row.row + part.shift + i], jacobian[source.row + i], part.weight)


@compiled
def _write_length(row: Any, table: TableArrays) -> None:
    """Write the length of another row's vector, and its Jacobian by the columns of the row.

    These joints move together: each has an equal part of the change by a common step of all. A
    gradient would move a thumb twice as far as two fingers that oppose it.
    """
    value, jacobian = table.value, table.jacobian
    source = table.records[table.parts[row.part].source]
    row.defined = source.defined
    vector = value[source.start : source.start + source.size]
    length = norm(vector)
    value[row.start] = length
    fill(jacobian[row.row], 0.0)
    if length == 0.0:
        return
    columns, change = table.support[row.column : row.column + row.columns], 0.0
    for column in columns:
        for i in range(source.rows):
            change += jacobian[source.row + i, column] * vector[i] / length
    for column in columns:
        jacobian[row.row, column] = change / len(columns)


@compiled
def _write_forces(row: Any, table: TableArrays, sensed: SensedArrays, frames: Floats) -> None:
    """Write measured forces along normals while all cells touch, as means of each joint."""
    forces, sharing = np.zeros(row.parts), np.zeros(row.parts)
    for i in range(row.parts):
        part = table.parts[row.part + i]
        frame, along = frames[part.frame], 0.0
        for k in range(3):
            turned = 0.0
            for inner in range(3):
                turned += frame[3 * k + inner] * part.normal[inner]
            along += turned * sensed.loads[part.cell, k]
        forces[part.shift] += along
        sharing[part.shift] += 1.0
        if not sensed.feeling[part.cell]:
            row.defined = READABLE
    for i in range(row.parts):
        first = table.parts[row.part + i].shift
        table.value[row.start + i] = forces[first] / sharing[first]


@compiled
def _write_displaced(row: Any, table: TableArrays) -> None:
    """Write a row displaced by a constant one, with stamp, radius and state of the former."""
    records, parts, value = table.records, table.parts, table.value
    base, offset = records[parts[row.part].source], records[parts[row.part + 1].source]
    row.defined, row.stamp, row.radius = base.defined, base.stamp, base.radius
    displace_value(
        value[base.start : base.start + base.size],
        value[offset.start : offset.start + offset.size],
        row.angular,
        value[row.start : row.start + row.size],
    )


@compiled
def displace_value(base: Floats, offset: Floats, angular: bool, result: Floats) -> None:
    """Displace a value (m,) in the world frame: add components, multiply rotations.

    Args:
        base: Value to displace.
        offset: Displacement in the form of the value.
        angular: True if the last nine components are a rotation.
        result: Output: displaced value.
    """
    linear = len(base) - 9 if angular else len(base)
    for i in range(linear):
        result[i] = base[i] + offset[i]
    if angular:
        multiply(offset[linear:], base[linear:], result[linear:])

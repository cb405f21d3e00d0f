"""Arrays of the signals in the form of compiled code."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.numeric.arrays import Booleans, Floats, Integers, Records


class SensedArrays(NamedTuple):
    """Measurements of the newest observation.

    Attributes:
        positions: Positions of the actuated joints, rad or m, shape (n,).
        loads: Loads of the load cells, N and N m, world frame, shape (cells, 6).
        feeling: True for each load cell in contact, shape (cells,).
    """

    positions: Floats
    loads: Floats
    feeling: Booleans


class TableArrays(NamedTuple):
    """Signal table; see ``table.SignalTable``.

    Attributes:
        records: Records of the rows, shape (capacity,) of ``refresh.ROW``.
        parts: Parts of the rows, shape (capacity,) of ``refresh.PART``.
        support: Joints and columns of rows and parts, shape (capacity,).
        value: Values of all rows in sequence, SI units, shape (capacity,).
        jacobian: Jacobian rows of all rows in sequence, SI units, shape (capacity, n).
    """

    records: Records
    parts: Records
    support: Integers
    value: Floats
    jacobian: Floats


class TreeArrays(NamedTuple):
    """Joint tree in the newest posture; see ``forward.place_joints``.

    Attributes:
        joints: Joints, parents first, shape (j,) of ``forward.JOINT``.
        frames: Frames of the base and of each joint, world frame, shape (j + 1, 12).
        axes: Axis of each joint, world frame, shape (j, 3).
    """

    joints: Records
    frames: Floats
    axes: Floats


class SignalArrays(NamedTuple):
    """Measurements, signal table and joint tree."""

    sensed: SensedArrays
    table: TableArrays
    tree: TreeArrays

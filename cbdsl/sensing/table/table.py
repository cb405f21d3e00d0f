"""Signal table: one row per resource, with its value and Jacobian in this tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats, Integers
from cbdsl.sensing.table.reading import CameraHeading, Reading
from cbdsl.sensing.table.refresh import DEFINED, PART, READABLE, ROW, UNDEFINED


class RowPart(NamedTuple):
    """One part of a row, as in ``refresh.PART``."""

    frame: int = 0
    origin: Sequence[float] | Floats = (0.0, 0.0, 0.0)
    rotation: Sequence[float] | Floats = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    support: Sequence[int] | Integers = ()
    source: int = -1
    weight: float = 0.0
    shift: int = 0
    cell: int = -1
    normal: Sequence[float] | Floats = (0.0, 0.0, 0.0)
    guide: int = -1
    angles: Sequence[float] | Floats = (0.0, 0.0)
    radius: float = 0.0


class Form(NamedTuple):
    """Form of a row.

    Attributes:
        kind: Kind of the row, one of the constants of ``refresh``.
        size: Number of components of the value.
        rows: Number of rows of the Jacobian.
        parts: Parts of the row.
        columns: Actuated joints that the row reads, or those of its Jacobian.
        linear, angular: True if the row has this motion of a tip.
        facing: Number of the row with the radius that a tip stands off from; -1 for none.
        standoff: Clearance, least and most distance, m.
    """

    kind: int
    size: int
    rows: int
    parts: Sequence[RowPart] = ()
    columns: Sequence[int] = ()
    linear: bool = True
    angular: bool = False
    facing: int = -1
    standoff: Sequence[float] = (0.0, 0.0, 0.0)


def records_of(parts: Sequence[RowPart]) -> NDArray[Any]:
    """Return parts as records for ``refresh``; the table sets the place of their support."""
    return np.array([(*each[:3], 0, len(each.support), *each[4:]) for each in parts], PART)


class _Room:
    """Allocator of blocks of places in an array."""

    def __init__(self) -> None:
        self._free: list[tuple[int, int]] = []
        self.end = 0

    def take(self, size: int) -> int:
        """Allocate a block and return its first place."""
        for number, (start, free) in enumerate(self._free):
            if free >= size:
                self._free[number] = start + size, free - size
                return start
        start, self.end = self.end, self.end + size
        return start

    def give_back(self, start: int, size: int) -> None:
        """Free a block."""
        # Adjacent free blocks are joined, because a longer row may not fit into either alone.
        blocks = sorted([*self._free, (start, size)])
        self._free = []
        for begin, free in blocks:
            if self._free and sum(self._free[-1]) == begin:
                self._free[-1] = self._free[-1][0], self._free[-1][1] + free
            elif free:
                self._free.append((begin, free))


class SignalTable:
    """Rows of resources: values, Jacobians, stamps and states.

    A row keeps its number while it is bound. The arrays are replaced if one of them has to grow;
    users that keep references compare ``version``.

    Args:
        joints: Number of actuated joints, n.

    Attributes:
        records: Records of the rows, shape (capacity,) of ``refresh.ROW``.
        parts: Parts of the rows, shape (capacity,) of ``refresh.PART``.
        support: Joints and columns of rows and parts, shape (capacity,).
        value: Values of all rows in sequence, SI units, shape (capacity,).
        jacobian: Jacobian rows of all rows in sequence, SI units, shape (capacity, n).
        version: Count of the replacements of arrays.
    """

    def __init__(self, joints: int) -> None:
        self.records: NDArray[Any] = np.zeros(16, ROW)
        self.parts: NDArray[Any] = np.zeros(16, PART)
        self.support: Integers = np.zeros(64, dtype=np.int64)
        self.value: Floats = np.zeros(128)
        self.jacobian: Floats = np.zeros((128, joints))
        self.version = 0
        self._renew()
        self._rooms = {
            name: _Room() for name in ("records", "parts", "support", "value", "jacobian")
        }

    def bind(self, form: Form) -> int:
        """Allocate a row of a form and return its number."""
        number = self._take("records", 1)
        start, row = self._take("value", form.size), self._take("jacobian", form.rows)
        part, column = self._take("parts", len(form.parts)), self._list(form.columns)
        firsts = [self._list(each.support) for each in form.parts]
        records = self.parts[part : part + len(form.parts)]
        records[:] = records_of(form.parts)
        records["support"] = firsts
        self.value[start : start + form.size] = 0.0
        self.jacobian[row : row + form.rows] = 0.0
        self.records[number] = (
            form.kind, start, form.size, row, form.rows, part, len(form.parts),
            form.linear, form.angular, column, len(form.columns),
            UNDEFINED, 0, 0.0, form.facing, form.standoff,
        )  # fmt: skip
        return number

    def unbind(self, number: int) -> None:
        """Free a row and its parts."""
        record = self.records[number]
        for part in self.parts[record["part"] : record["part"] + record["parts"]]:
            self._rooms["support"].give_back(int(part["support"]), int(part["joints"]))
        for room, start, size in (
            ("value", "start", "size"),
            ("jacobian", "row", "rows"),
            ("parts", "part", "parts"),
            ("support", "column", "columns"),
        ):
            self._rooms[room].give_back(int(record[start]), int(record[size]))
        self._rooms["records"].give_back(number, 1)
        record["defined"] = UNDEFINED
        self._parts.pop(number, None)

    def write(self, number: int, reading: Reading) -> None:
        """Write a reading to a row; ``None`` leaves the Jacobian unchanged."""
        values, rows = self._row(number)
        values[:] = reading.value.ravel()
        if reading.jacobian is not None:
            rows[:] = reading.jacobian
        if reading.cameras:
            self._write_cameras(number, reading.cameras)
        self._stamp[number], self._radius[number] = reading.stamp, reading.radius
        self._defined[number] = DEFINED if reading.measured else READABLE

    def _write_cameras(self, number: int, cameras: Sequence[CameraHeading]) -> None:
        """Write the cameras' own headings, if the row has a part for each camera."""
        record = self.records[number]
        first, count = record["part"], record["parts"]
        if count:
            self._weight[first : first + count] = 0.0
            for camera, share, angles in cameras:
                self._weight[first + camera], self._angles[first + camera] = share, angles

    def forget(self, number: int) -> None:
        """Set a row to undefined."""
        self._defined[number] = UNDEFINED

    def is_defined(self, number: int) -> bool:
        """Return whether a row holds a measurement."""
        return bool(self._defined[number] == DEFINED)

    def values(self, number: int) -> Floats:
        """Return the value of a row, a view of the table, shape (size,)."""
        return self._row(number)[0]

    def rows(self, number: int) -> Floats:
        """Return the Jacobian of a row, a view of the table, shape (rows, n)."""
        return self._row(number)[1]

    def _row(self, number: int) -> tuple[Floats, Floats]:
        """Return value and Jacobian of a row, views of the current arrays."""
        parts = self._parts.get(number)
        if parts is None:
            record = self.records[number]
            start, row = record["start"], record["row"]
            values = self.value[start : start + record["size"]]
            parts = self._parts[number] = values, self.jacobian[row : row + record["rows"]]
        return parts

    def _list(self, numbers: Sequence[int] | Integers) -> int:
        """Store numbers of joints or columns; return their first place."""
        first = self._take("support", len(numbers))
        self.support[first : first + len(numbers)] = numbers
        return first

    def _renew(self) -> None:
        """Renew the views after the arrays were replaced."""
        self.version += 1
        self._parts: dict[int, tuple[Floats, Floats]] = {}
        self._stamp, self._radius = self.records["stamp"], self.records["radius"]
        self._defined = self.records["defined"]
        self._weight, self._angles = self.parts["weight"], self.parts["angles"]

    def _take(self, name: str, size: int) -> int:
        """Allocate a block of an array, which grows if necessary."""
        start = self._rooms[name].take(size)
        array: NDArray[Any] = getattr(self, name)
        if self._rooms[name].end > len(array):
            longer = np.zeros((2 * self._rooms[name].end, *array.shape[1:]), array.dtype)
            longer[: len(array)] = array
            setattr(self, name, longer)
            self._renew()
        return start

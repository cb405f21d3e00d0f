"""Rows of the signal table with their keys, dependencies and readers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Integers
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import READ, WRITTEN
from cbdsl.sensing.table.table import Form, SignalTable

Reader = Callable[[], Reading | None]


class Selection(NamedTuple):
    """Rows that are refreshed together.

    Attributes:
        compiled: Numbers of the rows that ``refresh`` writes, dependencies first, shape (r,).
        read: Numbers of the rows that Python reads, with their readers.
    """

    compiled: Integers
    read: tuple[tuple[int, Reader], ...]


class SignalRows:
    """Rows of one signal table.

    Args:
        joints: Number of actuated joints, n.

    Attributes:
        table: Table of the rows.
    """

    def __init__(self, joints: int) -> None:
        self.table = SignalTable(joints)
        self._numbers: dict[tuple[object, ...], int] = {}
        self._readers: dict[int, Reader] = {}
        self._made_of: dict[int, tuple[int, ...]] = {}

    def bound(self, key: tuple[object, ...], bind: Callable[[], int]) -> int:
        """Return the number of the row with a key; bind the row at the first call.

        Args:
            key: Key of the row.
            bind: Function that binds the row.
        """
        number = self._numbers.get(key)
        if number is None:
            number = self._numbers[key] = bind()
        return number

    def bind(self, form: Form, made_of: Sequence[int] = ()) -> int:
        """Bind a row of a form and return its number.

        Args:
            form: Form of the row.
            made_of: Numbers of other rows that are refreshed before this one.
        """
        number = self.table.bind(form)
        below = (row for each in made_of for row in (*self._made_of.get(each, ()), each))
        self._made_of[number] = tuple(dict.fromkeys(below))
        return number

    def bind_written(self, size: int) -> int:
        """Bind a row that the caller writes with ``table.write``; return its number."""
        return self.table.bind(Form(WRITTEN, size, size))

    def bind_read(self, size: int, reader: Reader, form: Form | None = None) -> int:
        """Bind a row that Python reads; return its number.

        Args:
            size: Number of components.
            reader: Function that reads the row.
            form: Form of the row, by default one without parts.
        """
        number = self.table.bind(form or Form(WRITTEN, size, size))
        self._readers[number] = reader
        return number

    def release(self, number: int) -> None:
        """Free a row; no other row may depend on it."""
        self.table.unbind(number)
        self._readers.pop(number, None)
        self._made_of.pop(number, None)
        self._numbers = {key: row for key, row in self._numbers.items() if row != number}

    def select(self, rows: Iterable[int]) -> Selection:
        """Return rows and their dependencies, in the order for ``refresh``."""
        ordered: dict[int, None] = {}
        for number in rows:
            ordered.update(dict.fromkeys((*self._made_of.get(number, ()), number)))
        compiled = [n for n in ordered if self.table.records["kind"][n] not in READ]
        read = tuple((n, self._readers[n]) for n in ordered if n in self._readers)
        return Selection(np.array(compiled, dtype=np.int64), read)

    def refresh_read(self, selection: Selection) -> None:
        """Refresh the rows that Python reads."""
        for number, read in selection.read:
            reading = read()
            if reading is None:
                self.table.forget(number)
            else:
                self.table.write(number, reading)

"""Rows of the signal table that are known by a key, what they are made of, and who reads them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.reading import Reading
from cbdsl.sensing.refresh import WRITTEN
from cbdsl.sensing.table import Form, SignalTable

Integers = NDArray[np.int64]
Reader = Callable[[], Reading | None]


class Selection(NamedTuple):
    """Rows that are kept up to date together.

    Attributes:
        compiled: those that ``refresh`` writes, those that others are made of first, shape (r,).
        read: those that Python reads, and how.
    """

    compiled: Integers
    read: tuple[tuple[int, Reader], ...]


class SignalRows:
    """Rows of one table.

    Args:
        joints: number of actuated joints, n.

    Attributes:
        table: the rows.
    """

    def __init__(self, joints: int) -> None:
        self.table = SignalTable(joints)
        self._numbers: dict[tuple[object, ...], int] = {}
        self._readers: dict[int, Reader] = {}
        self._made_of: dict[int, tuple[int, ...]] = {}

    def bound(self, key: tuple[object, ...], bind: Callable[[], int]) -> int:
        """The row that is known by a key.

        Args:
            bind: makes it the first time.
        """
        number = self._numbers.get(key)
        if number is None:
            number = self._numbers[key] = bind()
        return number

    def bind(self, form: Form, made_of: Sequence[int] = ()) -> int:
        """A row of a form.

        Args:
            made_of: numbers of other rows, which are brought up to date before it.
        """
        number = self.table.bind(form)
        below = (row for each in made_of for row in (*self._made_of.get(each, ()), each))
        self._made_of[number] = tuple(dict.fromkeys(below))
        return number

    def bind_written(self, size: int) -> int:
        """A row of one's own, to be written with ``table.write``."""
        return self.table.bind(Form(WRITTEN, size, size))

    def bind_read(self, size: int, reader: Reader) -> int:
        """A row that Python reads."""
        number = self.bind_written(size)
        self._readers[number] = reader
        return number

    def release(self, number: int) -> None:
        """Take back a row, which nothing else may be made of."""
        self.table.unbind(number)
        self._readers.pop(number, None)
        self._made_of.pop(number, None)
        self._numbers = {key: row for key, row in self._numbers.items() if row != number}

    def select(self, rows: Iterable[int]) -> Selection:
        """Rows, and those that they are made of, as ``refresh`` wants them."""
        ordered: dict[int, None] = {}
        for number in rows:
            ordered.update(dict.fromkeys((*self._made_of.get(number, ()), number)))
        compiled = [n for n in ordered if self.table.records["kind"][n] != WRITTEN]
        read = tuple((n, self._readers[n]) for n in ordered if n in self._readers)
        return Selection(np.array(compiled, dtype=np.int64), read)

    def refresh_read(self, selection: Selection) -> None:
        """Bring those rows up to date that Python reads."""
        for number, read in selection.read:
            reading = read()
            if reading is None:
                self.table.forget(number)
            else:
                self.table.write(number, reading)

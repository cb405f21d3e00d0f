"""Rows are identified by their keys, and updated after the rows that they depend on."""

from __future__ import annotations

import numpy as np

from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import MIXTURE
from cbdsl.sensing.table.signal_rows import SignalRows
from cbdsl.sensing.table.table import Form, RowPart


def mixture(rows: SignalRows, *sources: int) -> int:
    parts = [RowPart(source=source, weight=1.0) for source in sources]
    return rows.bind(Form(MIXTURE, 3, 3, parts), sources)


def test_row_is_bound_once_for_a_key_until_it_is_released() -> None:
    rows, made = SignalRows(2), list[int]()

    def bind() -> int:
        made.append(rows.bind_written(3))
        return made[-1]

    assert rows.bound(("a",), bind) == rows.bound(("a",), bind) == made[0]
    assert rows.bound(("b",), bind) == made[1] != made[0]
    rows.release(made[0])
    rows.bound(("a",), bind)
    rows.bound(("b",), bind)
    assert len(made) == 3


def test_operands_of_a_row_are_bound_before_it_and_once() -> None:
    rows = SignalRows(2)
    given = rows.bind_written(3)
    read = rows.bind_read(3, lambda: None)
    below = mixture(rows, given, read)
    above = mixture(rows, below, given)
    selection = rows.select([above, below])
    assert selection.compiled.tolist() == [below, above]
    assert [number for number, _ in selection.read] == [read]


def test_row_read_by_python_is_written_or_undefined() -> None:
    rows = SignalRows(2)
    known: list[Reading | None] = [Reading(np.array([1.0, 2.0, 3.0]), None, 1), None]
    row = rows.bind_read(3, lambda: known.pop(0))
    selection = rows.select([row])
    rows.refresh_read(selection)
    assert rows.table.is_defined(row) and rows.table.values(row).tolist() == [1.0, 2.0, 3.0]
    rows.refresh_read(selection)
    assert not rows.table.is_defined(row)

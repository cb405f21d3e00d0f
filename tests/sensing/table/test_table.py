"""Rows that are bound and released in any order keep their own entries, and take no others."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import WRITTEN
from cbdsl.sensing.table.table import Form, RowPart, SignalTable
from cbdsl.types.resource import Origin

JOINTS = 5
TIMES = 1000


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


def drawn_form(rng: np.random.Generator) -> Form:
    """Draw a form of any size, with parts that any number of joints support."""
    parts = [
        RowPart(support=rng.integers(JOINTS, size=rng.integers(6))) for _ in range(rng.integers(4))
    ]
    columns = rng.integers(JOINTS, size=rng.integers(5)).tolist()
    return Form(WRITTEN, int(rng.integers(1, 40)), int(rng.integers(40)), parts, columns)


def lists(table: SignalTable, number: int) -> list[list[int]]:
    """Return the joints that a row's parts and its columns name."""
    record = table.records[number]
    parts = table.parts[record["part"] : record["part"] + record["parts"]]
    spans = [(part["support"], part["joints"]) for part in parts]
    spans.append((record["column"], record["columns"]))
    return [table.support[first : first + count].tolist() for first, count in spans]


def test_rows_keep_their_values_while_others_are_bound(rng: np.random.Generator) -> None:
    table, kept = SignalTable(JOINTS), dict[int, tuple[Form, Reading]]()
    versions = set()
    for stamp in range(TIMES):
        if kept and rng.random() < 0.45:
            number = int(rng.choice(list(kept)))
            table.unbind(number)
            del kept[number]
        else:
            form = drawn_form(rng)
            number = table.bind(form)
            assert number not in kept
            assert not table.values(number).any()
            assert not table.rows(number).any()
            assert not table.is_defined(number)
            reading = Reading(
                rng.normal(size=form.size), rng.normal(size=(form.rows, JOINTS)), stamp
            )
            table.write(number, reading)
            kept[number] = form, reading
        versions.add(table.version)
        for each, (_, reading) in kept.items() if stamp % 20 == 0 else ():
            np.testing.assert_array_equal(table.values(each), reading.value)
            np.testing.assert_array_equal(table.rows(each), reading.jacobian)
            assert np.shares_memory(table.values(each), table.value)
            assert table.records["stamp"][each] == reading.stamp
            assert table.is_defined(each)
    for each, (form, _) in kept.items():
        assert lists(table, each) == [*(list(part.support) for part in form.parts), [*form.columns]]
    assert len(kept) > 50
    assert len(versions) > 4


def test_released_row_is_reused(rng: np.random.Generator) -> None:
    table, bound = SignalTable(JOINTS), list[int]()
    for _ in range(TIMES):
        bound.append(table.bind(drawn_form(rng)))
        if len(bound) > 10:
            table.unbind(bound.pop(int(rng.integers(len(bound)))))
    # Ten rows of 40 numbers at most, and the gaps between them.
    assert len(table.records) <= 32
    assert len(table.value) <= 2048
    assert len(table.jacobian) <= 2048


def test_mixtures_follow_rows_that_have_moved_to_longer_arrays(
    dexter: RobotDocument, kinematics: Kinematics, rng: np.random.Generator
) -> None:
    named = resources(dexter)
    bindable = [each for each in named.values() if each.origin is Origin.KINEMATICS]
    signals, anew = (Signals(dexter, kinematics, ()) for _ in range(2))
    bound = dict[str, int]()
    for _ in range(TIMES):
        resource = bindable[int(rng.integers(len(bindable)))]
        row = bound.pop(resource.name, None)
        # Groups' rows are made of those of the tips' positions.
        if row is not None and not resource.name.endswith("_arm.position"):
            signals.release(row)
        else:
            bound[resource.name] = signals.bind(resource)
    kinematics.update(rng.uniform(kinematics.lower, kinematics.upper))
    for name, row in bound.items():
        found, expected = signals.reading(row, named[name].type.name), anew.read(named[name])
        assert found is not None and expected is not None
        np.testing.assert_array_equal(found.value, expected.value)
        np.testing.assert_array_equal(found.jacobian, expected.jacobian)

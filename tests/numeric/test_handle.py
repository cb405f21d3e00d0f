"""Handles: values converted once, borrowed by compiled code and kept alive."""

from __future__ import annotations

import gc
import sys
import weakref
from typing import NamedTuple

import numpy as np
import pytest
from numba import typeof

from cbdsl.numeric.arrays import Floats, Records
from cbdsl.numeric.compiled import compiled_once
from cbdsl.numeric.handle import Handle, bind, hold
from cbdsl.numeric.kernel_digest import describe_type

RECORD = np.dtype([("number", np.int64), ("vector", np.float64, 3)])


class Inner(NamedTuple):
    records: Records
    matrix: Floats


class Outer(NamedTuple):
    inner: Inner
    vector: Floats


class Renamed(NamedTuple):
    inner: Inner
    other: Floats


def outer() -> Outer:
    return Outer(Inner(np.zeros(2, RECORD), np.arange(6.0).reshape(2, 3)), np.ones(3))


@compiled_once
def _advance(arrays: Handle) -> float:
    held: Outer = arrays.held
    row = held.inner.matrix[1]
    held.vector[0] += row[2]
    held.inner.records[1].number += 1
    total: float = row[1:].sum() + held.vector[:2].sum()
    return total


@compiled_once
def _add(arrays: Handle, other: Floats) -> float:
    total: float = arrays.held.vector[0] + other[0]
    return total


def test_bind_values_shares_their_memory_with_compiled_code() -> None:
    values = outer()
    call = bind(_advance, values)
    assert call() == 9.0 + 7.0
    assert call() == 9.0 + 12.0
    assert values.vector[0] == 11.0
    assert values.inner.records["number"].tolist() == [0, 2]
    values.inner.matrix[1, 2] = 0.0
    assert call() == 4.0 + 12.0


def test_hold_of_other_arguments_passes_them_along() -> None:
    assert _add(hold(outer()), np.full(1, 2.0)) == 3.0


def test_bound_values_live_as_long_as_the_call() -> None:
    values = outer()
    gone = weakref.ref(values.vector)
    call = bind(_advance, values)
    del values
    gc.collect()
    assert gone() is not None
    assert call() == 16.0
    del call
    gc.collect()
    assert gone() is None


def test_bind_many_times_leaves_no_references() -> None:
    values = outer()
    bind(_advance, values)()
    before = sys.getrefcount(values.vector)
    for _ in range(100):
        bind(_advance, values)()
    assert sys.getrefcount(values.vector) < before + 10


@pytest.mark.parametrize("other", [
    Renamed(*outer()), Outer(outer().inner, np.ones(3, dtype=np.float32)),
    Outer(Inner(np.zeros(2, [("number", np.int32)]), np.zeros((2, 3))), np.ones(3)),
])  # fmt: skip
def test_describe_type_of_handles_tells_fields_and_elements_apart(other: NamedTuple) -> None:
    assert describe_type(typeof(hold(other))) != describe_type(typeof(hold(outer())))

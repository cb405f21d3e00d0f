"""Values of a compiled function, passed by one reference."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from numba import typeof, types
from numba.experimental import structref

from cbdsl.numeric.borrowed import borrow
from cbdsl.numeric.compiled import compiled_once

Result = TypeVar("Result")


@structref.register
class _HandleType(types.StructRef):
    """Type of a handle, by the type of the values."""


class Handle(structref.StructRefProxy):
    """Reference to values that compiled code reads as ``held``.

    A call of a compiled function converts each array of its arguments, which takes 0.1 us. It also
    finds the type of each named tuple, which may take longer than a control tick. The values of a
    handle are converted once.
    """

    __slots__ = ("owner",)

    held: Any
    owner: Any


structref.define_boxing(_HandleType, Handle)
structref.define_constructor(Handle, _HandleType, ["held"])


@compiled_once
def _hold(values: Any) -> Handle:
    """Return a handle of borrowed values."""
    return Handle(borrow(values))  # type: ignore[no-untyped-call]


def hold(values: Any) -> Handle:
    """Return a handle of values, such as named tuples of arrays, which it keeps alive."""
    handle = _hold(values)
    handle.owner = values
    return handle


def bind(function: Callable[[Handle], Result], values: Any) -> Callable[[], Result]:
    """Return a call of a compiled function with a handle of some values.

    Args:
        function: Function of a handle alone, from ``compiled_once``.
        values: Values of the handle, such as named tuples of arrays.
    """
    handle = hold(values)
    dispatcher: Any = function
    signature = (typeof(handle),)
    # Compilation waits for a lock that all threads share, even if there is nothing to compile.
    known = dispatcher.overloads.get(signature)
    entry = dispatcher.compile(signature) if known is None else known.entry_point
    return partial(entry, handle)

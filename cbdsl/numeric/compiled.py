"""Functions of arrays that become machine code when they are first called."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """A function that compiled ones call."""
    return cast(Function, njit(error_model="numpy")(function))


def compiled_sum(function: Function) -> Function:
    """A function that compiled ones call, whose sums may be added up in any order."""
    return cast(Function, njit(error_model="numpy", fastmath={"reassoc"})(function))


def compiled_once(function: Function) -> Function:
    """A function that Python calls, kept on disk with all it calls for the next process.

    It is kept beside the package or, where that is read-only, among the user's caches. Where
    neither can be written, every process compiles anew.
    """
    try:
        return cast(Function, njit(error_model="numpy", cache=True)(function))
    except RuntimeError:
        return compiled(function)

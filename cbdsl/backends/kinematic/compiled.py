"""Functions of arrays that become machine code when they are first called."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """A function that compiled ones call."""
    return cast(Function, njit(error_model="numpy")(function))


def compiled_once(function: Function) -> Function:
    """A function that Python calls, kept on disk for the next process where that can be written."""
    try:
        return cast(Function, njit(error_model="numpy", cache=True)(function))
    except RuntimeError:
        return compiled(function)

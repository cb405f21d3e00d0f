"""Functions of arrays that become machine code when they are first called."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])

# Compiled functions are called from compiled ones, some from Python, none from C.
_OUTER: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
_INNER: dict[str, Any] = {**_OUTER, "no_cpython_wrapper": True}

#: Files with one of these in them define compiled functions.
MARKS = (b"numeric.compiled import", b"control.potential import")


def compiled(function: Function) -> Function:
    """A function that compiled ones call."""
    return cast(
        Function,
        njit(**_INNER)(function),
    )


def compiled_sum(function: Function) -> Function:
    """A function that compiled ones call, whose sums may be added up in any order."""
    return cast(
        Function,
        njit(fastmath={"reassoc"}, **_INNER)(function),
    )


def compiled_once(function: Function) -> Function:
    """A function that Python calls, kept on disk with all it calls for the next process.

    Numba stamps what it keeps with the function's own file alone, so that after an edit of a callee
    the old code would run on. Here the stamp covers every file of the package, and of cbdsl, that
    defines compiled functions. The code is kept beside the package or, where that is read-only,
    among the user's caches. Where neither can be written, every process compiles anew.
    """
    dispatcher: Any = njit(**_OUTER)(function)
    with suppress(RuntimeError):  # there is no place to keep it
        dispatcher.enable_caching()
        dispatcher._cache._cache_file._source_stamp = stamp_of(function)
    return cast(Function, dispatcher)


def stamp_of(function: Callable[..., Any]) -> str:
    """A hash of all source files that a function's machine code may come from."""
    own = Path(inspect.getfile(function)).resolve()
    depth = function.__module__.count(".") if "." in function.__module__ else 0
    package = own.parents[depth - 1] if depth else own
    return _hash(package) + _hash(Path(__file__).resolve().parents[1])


@cache
def _hash(package: Path) -> str:
    """A hash of the files below a folder that define compiled functions, or of one file."""
    digest = hashlib.sha1(usedforsecurity=False)
    files = sorted(package.rglob("*.py")) if package.is_dir() else [package]
    for file in files:
        content = file.read_bytes()
        if package.is_file() or any(mark in content for mark in MARKS):
            digest.update(content)
    return digest.hexdigest()

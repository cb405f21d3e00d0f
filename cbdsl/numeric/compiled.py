"""Functions of arrays that are compiled to machine code at their first call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import FunctionType
from typing import Any, TypeVar, cast

from numba import njit
from numba.core.types import unliteral

from cbdsl.numeric.inlined_code import InlinedCompiler
from cbdsl.numeric.kernel_cache import KernelCache
from cbdsl.numeric.kernel_digest import reachable

Function = TypeVar("Function", bound=Callable[..., Any])

# Compiled functions are called from compiled ones, some from Python, none from C.
_OUTER: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
_INNER: dict[str, Any] = {
    **_OUTER, "no_cpython_wrapper": True, "pipeline_class": InlinedCompiler
}  # fmt: skip

#: Files with one of these in them define compiled functions.
MARKS = (b"numeric.compiled import", b"control.potential import")

# Functions of imported modules that Python calls.
_kernels: list[Any] = []


def compiled(function: Function) -> Function:
    """Return a compiled function for calls from other compiled functions."""
    return cast(Function, _without_literals(njit(**_INNER)(function)))


def compiled_sum(function: Function) -> Function:
    """Return a function for calls from compiled ones, with sums in any order."""
    return cast(Function, _without_literals(njit(fastmath={"reassoc"}, **_INNER)(function)))


def compiled_once(function: Function) -> Function:
    """Return a compiled function for calls from Python, kept on disk (see ``KernelCache``)."""
    dispatcher = _without_literals(njit(**_OUTER)(function))
    dispatcher._cache = KernelCache(dispatcher.py_func, str(sorted(_OUTER.items())))
    _kernels.append(dispatcher)
    return cast(Function, dispatcher)


def _without_literals(dispatcher: Any) -> Any:
    """Return a function that is compiled for the types of its arguments, not for their values.

    A variable that begins at 0 has the type of this literal until types are unified. Without this,
    other compiled functions with this argument would be compiled twice, without benefit.
    """
    resolve = dispatcher.get_call_template

    def resolve_types(args: Sequence[Any], kws: Mapping[str, Any]) -> Any:
        kinds = {name: unliteral(kind) for name, kind in kws.items()}
        return resolve(tuple(map(unliteral, args)), kinds)

    dispatcher.get_call_template = resolve_types
    return dispatcher


def load_kept() -> int:
    """Load all kept machine code of the functions of imported modules; return their number.

    A robot that moves cannot wait for a function that is loaded at its first call.
    """
    count = 0
    for kernel in _kernels:
        context = kernel.targetctx
        for kept in kernel._cache.load_others(list(kernel.overloads), context):
            # As a dispatcher does at the first call of a signature.
            context.insert_user_function(kept.entry_point, kept.fndesc, [kept.library])
            kernel.add_overload(kept)
            count += 1
    return count


def is_kept(kernel: Any) -> bool:
    """Return whether machine code of a function that Python calls is loaded or kept."""
    return bool(kernel.overloads) or kernel._cache.is_kept(kernel.targetctx.codegen())


def uncompiled() -> frozenset[FunctionType]:
    """Return the functions of imported modules whose machine code is neither loaded nor kept."""
    functions: set[FunctionType] = set()
    for kernel in _kernels:
        if not is_kept(kernel):
            functions |= reachable(kernel.py_func)
    return frozenset(functions)

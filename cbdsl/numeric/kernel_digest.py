"""Digests of compiled functions: equal digests give equal machine code on one processor."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from enum import EnumMeta
from functools import cache
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba import types
from numba.core.dispatcher import Dispatcher
from numba.core.typing.templates import Signature

_PLAIN = (
    bool, int, float, complex, str, bytes, slice, type(None), type(Ellipsis), np.generic, np.ufunc,
    Signature,
)  # fmt: skip


class NoDigestError(ValueError):
    """Dependency of a function on an object whose value cannot be described."""


def digest_of(function: FunctionType, options: str) -> str:
    """Return a digest of a function and of all functions that it calls.

    Comments, docstrings, annotations and places in files do not count; bytecode, constants and the
    values of global variables do.

    Args:
        function: Python function that is compiled.
        options: Options of its compilation.

    Raises:
        NoDigestError: A global variable has no describable value.
    """
    digest = hashlib.sha256(options.encode())
    for part in sorted({_own(reached) for reached in reachable(function)}):
        digest.update(part.encode())
    digest.update(_name(function).encode())
    return digest.hexdigest()


def reachable(function: FunctionType) -> frozenset[FunctionType]:
    """Return a function and the Python functions that it reaches by global variables."""
    functions: set[FunctionType] = set()
    waiting = [function]
    while waiting:
        current = waiting.pop()
        if current not in functions:
            functions.add(current)
            waiting += [callee for _, value in _globals(current) if (callee := _source(value))]
    return frozenset(functions)


def _source(value: object) -> FunctionType | None:
    """Return the Python function of a compiled function or an intrinsic."""
    if isinstance(value, Dispatcher):
        source: FunctionType = value.py_func
        return source
    definition = getattr(value, "_defn", value)  # an intrinsic keeps its definition there
    return definition if isinstance(definition, FunctionType) else None


@cache
def _own(function: FunctionType) -> str:
    """Describe a function without the functions that it calls, but with their names."""
    parts = [_name(function), _code(function.__code__, function.__doc__)]
    parts += [f"{name}={_value(value)}" for name, value in _globals(function)]
    cells = function.__closure__ or ()
    parts += [_value(cell.cell_contents) for cell in cells]
    parts.append(_value(function.__defaults__))
    return "\n".join(parts)


def _name(function: FunctionType) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _code(code: CodeType, documentation: str | None = None) -> str:
    """Describe bytecode and its constants, without docstring and line numbers."""
    constants = [
        _code(constant) if isinstance(constant, CodeType) else repr(constant)
        for constant in code.co_consts
        if constant is None or constant != documentation
    ]
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    return f"{code.co_code.hex()} {constants} {names}"


def _globals(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield global variables that a function names, and attributes of its package's modules."""
    package = function.__module__.partition(".")[0]
    for code in _codes(function.__code__):
        for name in sorted(code.co_names):
            if name not in function.__globals__:
                continue
            value = function.__globals__[name]
            yield name, value
            if isinstance(value, ModuleType) and value.__name__.partition(".")[0] == package:
                for attribute in sorted(code.co_names):
                    if hasattr(value, attribute):
                        yield f"{name}.{attribute}", getattr(value, attribute)


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _value(value: object) -> str:
    """Describe the value of a global variable.

    Raises:
        NoDigestError: It has no describable value.
    """
    if isinstance(value, Dispatcher):
        return f"compiled {_name(value.py_func)} {sorted(value.targetoptions.items())}"
    source = _source(value)
    if source is not None:
        return f"function {_name(source)}"
    if isinstance(value, _PLAIN):
        return repr(value)
    if isinstance(value, (tuple, frozenset)):
        return f"{type(value).__name__} {[_value(item) for item in value]}"
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return f"array {value.dtype} {value.shape} {value.tobytes().hex()}"
    if isinstance(value, (ModuleType, BuiltinFunctionType)):
        return value.__name__
    return _type(value)


def _type(value: object) -> str:
    """Describe a class or a type of the compiler, with the members that code refers to."""
    if isinstance(value, EnumMeta):
        members: list[object] = list(value)
        return f"{value.__module__}.{value.__qualname__} {members!r}"
    if isinstance(value, type):
        return f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', ())}"
    if isinstance(value, types.Type):
        return describe_type(value)
    raise NoDigestError(f"{type(value).__name__} {value!r}")


def describe_type(kind: Any) -> str:
    """Describe a type of the compiler, with the fields of named tuples and handles."""
    if isinstance(kind, types.StructRef):
        held = [(name, describe_type(part)) for name, part in kind.field_dict.items()]
        return f"{type(kind).__qualname__} {held}"
    fields = getattr(getattr(kind, "instance_class", None), "_fields", ())
    is_tuple = isinstance(kind, types.BaseTuple)
    parts = tuple(kind) if is_tuple else ()
    return f"{kind} {fields} {[describe_type(part) for part in parts]}"

"""Functions that expressions of xacro may call: the documented ones, with bounded results."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import islice
from typing import Any

from cbdsl_formats.budget import MOST_PARTS, require_small


class ModelFunction:
    """Function that expressions may call; other objects are not called.

    Args:
        call: Function of the arguments.
    """

    def __init__(self, call: Callable[..., Any]) -> None:
        self._call = call

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        """Return the function's result."""
        return self._call(*arguments, **keywords)


class Namespace(dict[str, Any]):
    """Functions and constants with dotted names, as in ``math.pi``."""


def method(owner: Any, name: str) -> ModelFunction | None:
    """Return a method of a text, list or dictionary, if expressions may call it."""
    for kind, methods in _METHODS.items():
        if isinstance(owner, kind) and name in methods:
            return ModelFunction(partial(methods[name], owner))
    return None


def _listed(values: Iterable[Any]) -> list[Any]:
    """Return a list of values with a bounded length."""
    # One value beyond the bound suffices to detect an excess, so an endless iterator is not
    # exhausted.
    listed = list(islice(values, MOST_PARTS + 1))
    require_small(len(listed))
    return listed


def _mapped(function: ModelFunction, *values: Iterable[Any]) -> list[Any]:
    return [_called(function, *arguments) for arguments in zip(*map(_listed, values), strict=False)]


def _filtered(function: ModelFunction | None, values: Iterable[Any]) -> list[Any]:
    return [value for value in _listed(values) if (_called(function, value) if function else value)]


def _called(function: Any, *arguments: Any) -> Any:
    if not isinstance(function, ModelFunction):
        raise TypeError(f"{function!r} is not a function")
    return function(*arguments)


def _text(value: Any = "") -> str:
    return value if isinstance(value, str) else str(value)


def _replaced(text: str, old: str, new: str) -> str:
    # The size is checked before the text is created; repeated replacements grow it exponentially.
    require_small(len(text) + text.count(old) * len(new))
    return text.replace(old, new)


def _joined(text: str, parts: Iterable[str]) -> str:
    listed = _listed(parts)
    require_small(sum(map(len, listed)) + len(text) * len(listed))
    return text.join(listed)


def tokenize(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """Split a text at each of the given characters."""
    signs = sep or " "
    for sign in signs:
        text = text.replace(sign, signs[0])
    return [part for part in text.split(signs[0]) if part or not skip_empty]


def _rounded(value: float, digits: int | None = None) -> Any:
    return round(value) if digits is None else round(float(value), digits)


def _limited_range(*bounds: int) -> list[int]:
    require_small(len(range(*bounds)))
    return list(range(*bounds))


def _silent(*_: Any, **__: Any) -> str:
    """Return an empty text, because messages of a model are not printed."""
    return ""


def _failed(*words: Any) -> str:
    raise ValueError(" ".join(map(_text, words)))


_PYTHON: Mapping[str, Callable[..., Any]] = {
    "abs": abs,
    "all": all,
    "any": any,
    "bool": bool,
    "dict": dict,
    "divmod": divmod,
    "enumerate": lambda values, start=0: _listed(enumerate(values, start)),
    "filter": _filtered,
    "float": float,
    "int": int,
    "len": len,
    "list": lambda values=(): _listed(values),
    "map": _mapped,
    "max": max,
    "min": min,
    "ord": ord,
    "range": _limited_range,
    "repr": repr,
    "reversed": lambda values: _listed(reversed(values)),
    "round": _rounded,
    "sorted": sorted,
    "str": _text,
    # A start of another type than a number would join lists in quadratic time.
    "sum": lambda values, start=0: sum(_listed(values), float(start) if start else 0),
    "tuple": lambda values=(): tuple(_listed(values)),
    "zip": lambda *values: _listed(zip(*values, strict=False)),
}
# Functions of the module with bounded results: no factorial, no binomial.
_MATH = (
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "copysign", "cos"),
    *("cosh", "degrees", "dist", "erf", "erfc", "exp", "expm1", "fabs", "floor", "fmod", "frexp"),
    *("fsum", "gamma", "hypot", "isclose", "isfinite", "isinf", "isnan", "ldexp", "lgamma"),
    *("log", "log10", "log1p", "log2", "modf", "pow", "radians", "remainder", "sin", "sinh"),
    *("sqrt", "tan", "tanh", "trunc"),
)
_CONSTANTS = ("e", "inf", "nan", "pi", "tau")
_GLOBAL = (
    *("list", "dict", "map", "len", "str", "float", "int", "bool", "min", "max", "round"),
    *("sorted", "range"),
)
_METHODS: Mapping[type | tuple[type, ...], Mapping[str, Callable[..., Any]]] = {
    str: {
        **{name: getattr(str, name) for name in ("lower", "upper", "strip", "lstrip", "rstrip")},
        **{name: getattr(str, name) for name in ("split", "startswith", "endswith", "find")},
        "join": _joined,
        "replace": _replaced,
    },
    Mapping: {
        "get": lambda owner, key, default=None: owner.get(key, default),
        "items": lambda owner: _listed(owner.items()),
        "keys": lambda owner: _listed(owner.keys()),
        "values": lambda owner: _listed(owner.values()),
    },
    (list, tuple): {
        "count": lambda owner, value: owner.count(value),
        "index": lambda owner, value: owner.index(value),
    },
}


def functions(of_model: Mapping[str, Callable[..., Any]]) -> dict[str, Any]:
    """Return the functions and constants of xacro's documentation, by name.

    Args:
        of_model: Functions in the namespace ``xacro`` that depend on the model, by name.
    """
    python = Namespace({name: ModelFunction(call) for name, call in _PYTHON.items()})
    numbers = Namespace({name: ModelFunction(getattr(math, name)) for name in _MATH})
    numbers |= {name: getattr(math, name) for name in _CONSTANTS}
    own = {name: ModelFunction(call) for name, call in of_model.items()}
    messages = dict.fromkeys(
        ("message", "warning", "error", "print_location"), ModelFunction(_silent)
    )
    others = {
        "fatal": ModelFunction(_failed),
        "tokenize": ModelFunction(tokenize),
        "dotify": ModelFunction(dict),
    }
    return {
        **numbers,
        **{name: python[name] for name in _GLOBAL},
        **{name: own[name] for name in own if name != "arg"},
        "dotify": others["dotify"],
        "math": numbers,
        "python": python,
        "xacro": Namespace({**own, **messages, **others}),
    }

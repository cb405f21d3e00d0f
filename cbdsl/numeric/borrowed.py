"""Arrays that compiled code uses without counting references to them.

Numba counts the references to each array, also if a function only reads a field of a named tuple. A
control tick would call a function for that several hundred times. A borrowed array has the machine
representation of an array without an owner. Its caller keeps the memory alive. Its views have the
types of ordinary arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import types
from numba.extending import intrinsic, models, register_model

Values = TypeVar("Values")


class Borrowed(types.Array):
    """Type of a borrowed array.

    Args:
        array: Type of the same array with an owner.
    """

    def __init__(self, array: Any) -> None:
        super().__init__(
            array.dtype,
            array.ndim,
            array.layout,
            readonly=not array.mutable,
            name=f"borrowed {array}",
            aligned=array.aligned,
        )


@register_model(Borrowed)
class _BorrowedModel(models.ArrayModel):
    """Machine representation of a borrowed array."""

    def traverse(self, builder: Any) -> list[Any]:
        """Return the parts with references to count: none."""
        return []

    def contains_nrt_meminfo(self) -> bool:
        """Return whether references count."""
        return False


def _type_of(kind: Any) -> Any:
    """Return a type with borrowed arrays in place of arrays, also in named tuples."""
    if isinstance(kind, Borrowed):
        return kind
    if isinstance(kind, types.Array):
        return Borrowed(kind)
    if isinstance(kind, types.BaseNamedTuple):
        parts: Any = kind
        return types.NamedTuple([_type_of(part) for part in parts], parts.instance_class)
    return kind


def _without_owner(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return the machine representation of values with borrowed arrays."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = array.meminfo.type(None)
        array.parent = array.parent.type(None)
        return array._getvalue()
    if isinstance(kind, types.BaseNamedTuple):
        parts: Any = kind
        for place, part in enumerate(parts):
            inner = builder.extract_value(value, place)
            value = builder.insert_value(
                value, _without_owner(context, builder, part, inner), place
            )
    return value


def _borrow(typing_context: Any, values: Any) -> Any:
    """Return values with borrowed arrays; later code has to use their owner."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _without_owner(context, builder, signature.args[0], arguments[0])

    return _type_of(values)(values), generate


#: Function for compiled code: returns values, such as named tuples of arrays, with borrowed arrays.
#: Later code has to use the owner of the values, which otherwise ends too early.
borrow = cast("Callable[[Values], Values]", intrinsic(_borrow))

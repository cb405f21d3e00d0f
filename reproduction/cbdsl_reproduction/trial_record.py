"""Conversion of records of trials to plain data for JSON, and back by their field types."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

Some = TypeVar("Some")


def plain_data(value: Any) -> Any:
    """Return the plain data of a named tuple, of its contents, or of a value of JSON.

    Args:
        value: Value to convert; its method ``as_data`` takes precedence.
    """
    if hasattr(value, "as_data"):
        return value.as_data()
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {key: plain_data(each) for key, each in value.items()}
    if isinstance(value, tuple | list):
        return [plain_data(each) for each in value]
    return value


def read_record(kind: type[Some], data: object) -> Some:
    """Return the named tuple that ``plain_data`` converted.

    Args:
        kind: Class of the record; its method ``from_data`` takes precedence. Fields may be named
            tuples, and sequences and mappings by text, which become tuples and dictionaries.
        data: Values by the names of the fields; fields with a default may be missing.

    Raises:
        ValueError: The data do not match the class.
    """
    own: Callable[[object], Some] | None = getattr(kind, "from_data", None)
    if own:
        return own(data)
    if not isinstance(data, Mapping):
        raise ValueError(f"no {kind.__name__}: {data!r}")
    hints = get_type_hints(kind)
    unknown = {*data} - {*hints}
    missing = {*hints} - {*data} - {*vars(kind)["_field_defaults"]}
    if unknown or missing:
        names = ", ".join(sorted(unknown | missing))
        raise ValueError(f"no {kind.__name__}: missing or unknown: {names}")
    return kind(**{name: _read(hints[name], value) for name, value in data.items()})


def _read(kind: Any, value: Any) -> Any:
    """Return a field's value from plain data."""
    origin = get_origin(kind)
    if origin is Mapping:
        if not isinstance(value, Mapping):
            raise ValueError(f"no names and values: {value!r}")
        return {key: _read(get_args(kind)[1], each) for key, each in value.items()}
    if origin in (tuple, Sequence):
        if not isinstance(value, list | tuple):
            raise ValueError(f"no list: {value!r}")
        return tuple(_read(get_args(kind)[0], each) for each in value)
    return read_record(kind, value) if hasattr(kind, "_fields") else value

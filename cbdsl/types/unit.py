"""Quantities as text: ``30 deg``, ``5 N``, ``2 cm``, read into SI."""

import math
import re
from typing import NamedTuple

#: Regular expression of a decimal number.
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"^\s*({NUMBER})\s*(\S.*?)?\s*$")
# Input such as ``0,5 m``, which has a decimal comma instead of a point.
_DECIMAL_COMMA = r"^\s*([+-]?\d+),(\d+(?:\s*[a-zA-Z/][\w/^ ]*)?)\s*$"


class Unit(NamedTuple):
    """Unit of one dimension: ``factor`` times the SI unit of ``dimension``."""

    symbol: str
    dimension: str
    factor: float


def _units() -> dict[str, Unit]:
    # The first unit of each dimension is its SI unit; the JSON Schemas rely on this order. Each
    # symbol belongs to one dimension only.
    table = {
        "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3},
        "angle": {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3},
        "time": {"s": 1.0, "ms": 1e-3, "min": 60.0},
        "rate": {"Hz": 1.0, "/s": 1.0, "1/s": 1.0, "kHz": 1e3},
        "mass": {"kg": 1.0, "g": 1e-3},
        "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
        "torque": {"N m": 1.0, "Nm": 1.0},
        "speed": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
        "speed per force": {"m/s/N": 1.0, "cm/s/N": 1e-2, "mm/s/N": 1e-3},
        "angular speed": {"rad/s": 1.0, "deg/s": math.pi / 180},
        "acceleration": {"m/s^2": 1.0, "cm/s^2": 1e-2},
        "angular acceleration": {"rad/s^2": 1.0, "deg/s^2": math.pi / 180},
        "stiffness": {"N/m": 1.0},
        "contact damping": {"N s/m": 1.0},
        "angular stiffness": {"N/rad": 1.0},
        "torsional stiffness": {"N m/rad": 1.0},
        "volume": {"m^3": 1.0, "l": 1e-3, "ml": 1e-6, "cm^3": 1e-6},
        "pixels": {"px": 1.0},
    }
    return {
        symbol: Unit(symbol, dimension, factor)
        for dimension, units in table.items()
        for symbol, factor in units.items()
    }


UNITS: dict[str, Unit] = _units()


class QuantityError(ValueError):
    """Error of a text that is not a quantity, or has another dimension; see its message."""


def parse_quantity(text: str) -> tuple[float, Unit | None]:
    """Read a number and its unit.

    Returns:
        The value in SI, and the unit or ``None`` if no unit was written.

    Raises:
        QuantityError: The text is not a number, or its unit is unknown.
    """
    if "," in text and (comma := re.match(_DECIMAL_COMMA, text)):
        raise QuantityError(f"'{text}' has a decimal comma; write '{comma[1]}.{comma[2]}'")
    match = _QUANTITY.match(text)
    if not match:
        raise QuantityError(f"'{text}' is not a number with a unit")
    number, symbol = float(match[1]), match[2]
    if symbol is None:
        return number, None
    unit = UNITS.get(symbol)
    if unit is None:
        raise QuantityError(f"'{symbol}' is not a unit")
    return number * unit.factor, unit


def dimensions_of(unit: str) -> tuple[str, ...]:
    """Return the dimensions of an SI unit, or of the units of which it may be one."""
    return tuple(
        UNITS[each].dimension if each in UNITS else "number" for each in unit.split(" or ")
    )


def is_quantity(text: str) -> bool:
    """Return whether a text is a number, with or without a unit."""
    try:
        parse_quantity(text)
    except QuantityError:
        return False
    return True


def read_quantity(value: object, dimensions: tuple[str, ...]) -> float:
    """Read a value given as an SI number or as text with a unit of one of ``dimensions``.

    Raises:
        QuantityError: The value is neither, is not finite, or has a unit of another dimension.
    """
    # In Python, a truth value is an integer as well, but ``true`` is not a quantity.
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise QuantityError(f"expected {_wanted(dimensions)}")
    try:
        number, unit = parse_quantity(value) if isinstance(value, str) else (float(value), None)
    except QuantityError as error:
        raise QuantityError(f"{error}; expected {_wanted(dimensions)}") from None
    # An integer of 400 digits is valid YAML and exceeds the range of a float.
    except OverflowError:
        raise QuantityError("this number is too large") from None
    if unit is not None and unit.dimension not in dimensions:
        raise QuantityError(
            f"'{value}' has the dimension {unit.dimension}; expected {_wanted(dimensions)}"
        )
    # A text such as ``1e400`` becomes infinite without an exception.
    if not math.isfinite(number):
        raise QuantityError(f"{value!r} is not finite")
    return number


def _wanted(dimensions: tuple[str, ...]) -> str:
    if not dimensions:
        return "a number without a unit"
    symbols = (unit.symbol for unit in UNITS.values() if unit.dimension in dimensions)
    return f"{' or '.join(dimensions)} ({', '.join(symbols)})"

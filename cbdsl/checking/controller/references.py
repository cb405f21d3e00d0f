"""Reference literals: numbers with units for a feedback's components, and forces along normals."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from cbdsl.diagnostics.counting import count
from cbdsl.program.controller import AlongNormals, Literal
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import normals_of
from cbdsl.types.unit import QuantityError, dimensions_of, is_quantity, read_quantity

#: The feedback of a controller at its activation.
HERE = "here"

_ALONG_NORMALS = re.compile(r"(?P<force>.*\S)\s+along\s+normals\s*\Z")
_RELATIVE = re.compile(r"(?P<base>[^\s+-]+)\s*(?:(?P<sign>[+-])\s*(?P<offset>.*))?", re.DOTALL)
_NUMBER = re.compile(r"\s*[-+.]?\.?\d")

#: Types whose literals may end with a quaternion, with the number of components before it.
_QUATERNIONS = {"orientation": 0, "pose": 3}
# With four decimals a component, the norm of a unit quaternion is within this distance of 1.
_UNIT = 2e-3


class LiteralError(Exception):
    """Error of a literal that does not suit its feedback.

    Attributes:
        code: Code of the diagnostic in the catalogue.
        details: Values for the placeholders of its message.
        item: Index of the component, if the literal has several.
    """

    def __init__(self, code: str, details: dict[str, object], item: int | None = None) -> None:
        super().__init__(code)
        self.code = code
        self.details = details
        self.item = item


def is_literal(text: str) -> bool:
    """Return whether a reference's text is a quantity instead of a resource's name."""
    return _NUMBER.match(text) is not None


class RelativeText(NamedTuple):
    """Reference that is written as a base and a displacement, such as ``here + [0 cm, 2 cm]``.

    Attributes:
        base: Name of a resource, or ``HERE``.
        sign: Sign of the displacement, 1 or -1.
        offset: Quantities of the displacement; a single 0 if none is written.
    """

    base: str
    sign: int
    offset: tuple[str, ...]


def read_relative(text: str) -> RelativeText | None:
    """Return the parts of a relative reference, or ``None`` for any other text."""
    match = _RELATIVE.fullmatch(text.strip())
    if match is None or (match["sign"] is None and match["base"] != HERE):
        return None
    offset = (match["offset"] or "0").strip()
    inner = offset[1:-1] if offset[:1] == "[" and offset[-1:] == "]" else offset
    items = tuple(item.strip() for item in inner.split(","))
    return RelativeText(match["base"], -1 if match["sign"] == "-" else 1, items)


def read_literal(
    value: str | float | tuple[str | float, ...],
    feedback: Resource,
    axes: tuple[int, ...] | None = None,
) -> Literal | AlongNormals:
    """Return a reference literal in SI units.

    Args:
        value: Quantities of the literal.
        feedback: Feedback that it is compared with.
        axes: Axes of the given components; ``None`` for all. Other components become 0.

    Raises:
        LiteralError: The literal does not suit the feedback.
    """
    if isinstance(value, str) and (match := _ALONG_NORMALS.match(value)):
        return _along_normals(match["force"], feedback)
    items = value if isinstance(value, tuple) else (value,)
    kind = feedback.type
    # An orientation has 3 components and a pose 6, so that 4 or 7 numbers can only end with a
    # quaternion.
    if kind.factors == 1 and len(items) == _QUATERNIONS.get(kind.name, math.inf) + 4:
        items = _with_rotation_vector(items)
    places = range(kind.size) if axes is None else _places(axes, kind.factors)
    if len(items) not in (1, len(places)):
        raise _wrong_count(len(items), feedback, axes)
    # A single 0 stands for all components, in any of their units.
    units = [feedback.type.units[i] for i in places]
    of = [[unit] for unit in units] if len(items) == len(places) else [units]
    numbers = tuple(_component(item, i, of[i], feedback) for i, item in enumerate(items))
    if len(numbers) < len(places):
        if numbers[0] != 0:
            raise _wrong_count(1, feedback, axes)
        numbers = (0.0,) * len(places)
    values = [0.0] * kind.size
    for place, number in zip(places, numbers, strict=True):
        values[place] = number
    return Literal(tuple(values))


def _with_rotation_vector(items: tuple[str | float, ...]) -> tuple[str | float, ...]:
    """Replace the last four items, a unit quaternion (x, y, z, w), by a rotation vector, rad.

    Raises:
        LiteralError: One of the four is not a number, or they are not a unit quaternion.
    """
    first = len(items) - 4
    numbers = [_quantity(item, (), first + i) for i, item in enumerate(items[first:])]
    norm = math.hypot(*numbers)
    if abs(norm - 1.0) > _UNIT:
        raise LiteralError("CB593", {"norm": f"{norm:.4g}"})
    # Of the two quaternions of a rotation, use that of the shorter turn.
    x, y, z, w = (number if numbers[3] >= 0 else -number for number in numbers)
    # A quaternion is (sin(theta / 2) u, cos(theta / 2)) for a turn by theta about the unit vector
    # u. The rotation vector is theta u. The factor theta / sin(theta / 2) tends to 2 as theta tends
    # to 0.
    sine = math.hypot(x, y, z)
    factor = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 2.0
    return (*items[:first], factor * x, factor * y, factor * z)


def _places(axes: tuple[int, ...], factors: int) -> list[int]:
    """Return the indices of the components along some axes, for each of several vectors in turn."""
    return [3 * factor + axis for factor in range(factors) for axis in axes]


def _along_normals(force: str, feedback: Resource) -> AlongNormals:
    if normals_of(feedback) is None:
        details = {"name": feedback.name, "feedback": feedback.type}
        raise LiteralError("CB512", dict(details))
    return AlongNormals(_quantity(force, ("force",), None))


def _component(item: str | float, index: int, units: list[str], feedback: Resource) -> float:
    dimensions = dict.fromkeys(each for unit in units for each in dimensions_of(unit))
    try:
        return _quantity(item, tuple(dimensions), index)
    except LiteralError as error:
        if isinstance(item, str) and is_quantity(item):  # it is the unit that does not fit
            error.details["problem"] = (
                f"{error.details['problem']} for the feedback '{feedback.name}'"
            )
        raise


def _quantity(value: str | float, dimensions: tuple[str, ...], item: int | None) -> float:
    try:
        return read_quantity(value, dimensions)
    except QuantityError as error:
        from cbdsl.types.quantity_problem import quantity_problem  # only a fault needs it

        raise LiteralError("CB506", {"problem": quantity_problem(value, error)}, item) from None


def _wrong_count(number: int, feedback: Resource, axes: tuple[int, ...] | None) -> LiteralError:
    kind = feedback.type
    given = f"{count(number, 'number')} {'is' if number == 1 else 'are'}"
    wanted = count(kind.size, "component")
    if axes is not None:
        named = ", ".join("xyz"[axis] for axis in axes)
        wanted = f"{count(len(axes) * kind.factors, 'component')} along axes [{named}]"
    if normals_of(feedback) is not None and kind.factors > 1:
        wanted += "; '2 N along normals' gives each a force along its own normal"
    details = {"found": given, "feedback": kind, "wanted": wanted}
    return LiteralError("CB505", dict(details))

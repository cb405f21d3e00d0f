"""Reference literals: numbers with units for a feedback's components, and forces along normals."""

from __future__ import annotations

import re

from cbdsl.errors.counting import count
from cbdsl.program.controller import AlongNormals, Literal
from cbdsl.types.resource import FingerForces, NetForces, Resource
from cbdsl.types.unit import QuantityError, is_quantity, read_quantity

_ALONG_NORMALS = re.compile(r"(?P<force>.*\S)\s+along\s+normals\s*\Z")
_NUMBER = re.compile(r"\s*[-+.]?\.?\d")

# Physical dimensions of a value's components; several share the components evenly.
_DIMENSIONS: dict[str, tuple[str, ...]] = {
    "configuration": ("angle",),
    "wrench": ("force", "torque"),
    "force": ("force",),
    "torque": ("torque",),
    "heading": ("angle",),
    "pose": ("length", "angle"),
    "position": ("length",),
    "orientation": ("angle",),
}


class LiteralError(Exception):
    """A literal does not suit its feedback.

    Attributes:
        code: in the catalogue.
        details: what fills its message.
        item: which component, where it is one of several.
    """

    def __init__(self, code: str, details: dict[str, object], item: int | None = None) -> None:
        super().__init__(code)
        self.code = code
        self.details = details
        self.item = item


def is_literal(text: str) -> bool:
    """Whether a reference's text is a quantity instead of a resource's name."""
    return _NUMBER.match(text) is not None


def read_literal(
    value: str | float | tuple[str | float, ...], feedback: Resource
) -> Literal | AlongNormals:
    """A reference literal in SI.

    Raises:
        LiteralError: it does not suit the feedback.
    """
    if isinstance(value, str) and (match := _ALONG_NORMALS.match(value)):
        return _along_normals(match["force"], feedback)
    items = value if isinstance(value, tuple) else (value,)
    kind = feedback.type
    if len(items) not in (1, kind.size):
        raise _wrong_count(len(items), feedback)
    numbers = tuple(_component(item, i, feedback) for i, item in enumerate(items))
    if len(numbers) == kind.size:
        return Literal(numbers)
    if numbers[0] != 0:
        raise _wrong_count(1, feedback)
    return Literal((0.0,) * kind.size)


def _along_normals(force: str, feedback: Resource) -> AlongNormals:
    if not isinstance(feedback.source, (FingerForces, NetForces)):
        details = {"name": feedback.name, "feedback": feedback.type}
        raise LiteralError("CB512", dict(details))
    return AlongNormals(_quantity(force, ("force",), None))


def _component(item: str | float, index: int, feedback: Resource) -> float:
    kind = feedback.type
    dimensions = _DIMENSIONS[kind.name]
    place = (index % kind.dimension) * len(dimensions) // kind.dimension
    try:
        return _quantity(item, (dimensions[place],), index)
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
        from cbdsl.types.quantity_slip import quantity_problem  # only a fault needs it

        raise LiteralError("CB506", {"problem": quantity_problem(value, error)}, item) from None


def _wrong_count(number: int, feedback: Resource) -> LiteralError:
    kind = feedback.type
    given = f"{count(number, 'number')} {'is' if number == 1 else 'are'}"
    wanted = count(kind.size, "component")
    if isinstance(feedback.source, (FingerForces, NetForces)):
        wanted += "; '2 N along normals' gives each a force along its own normal"
    details = {"found": given, "feedback": kind, "wanted": wanted}
    return LiteralError("CB505", dict(details))

"""What every document shares: strictness, immutability, the version key and named quantities."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from cbdsl.types.unit import read_quantity

NAME_PATTERN = r"^[A-Za-z][A-Za-z0-9_]*$"
Name = Annotated[str, Field(pattern=NAME_PATTERN)]


def _quantity(*dimensions: str) -> BeforeValidator:
    return BeforeValidator(lambda value: read_quantity(value, dimensions))


Number = Annotated[float, _quantity()]
Length = Annotated[float, _quantity("length")]
Angle = Annotated[float, _quantity("angle")]
Time = Annotated[float, _quantity("time"), Field(ge=0)]
Rate = Annotated[float, _quantity("rate"), Field(gt=0)]
Mass = Annotated[float, _quantity("mass"), Field(gt=0)]
Force = Annotated[float, _quantity("force")]
Torque = Annotated[float, _quantity("torque")]
Speed = Annotated[float, _quantity("speed")]
AngularSpeed = Annotated[float, _quantity("angular speed")]
AnySpeed = Annotated[float, _quantity("speed", "angular speed"), Field(gt=0)]
AnyAcceleration = Annotated[float, _quantity("acceleration", "angular acceleration"), Field(gt=0)]
Share = Annotated[float, _quantity(), Field(ge=0)]
Pixels = Annotated[float, _quantity("pixels"), Field(gt=0)]


def _span(value: Any) -> Any:
    """A scalar stands for the span from itself to itself."""
    return value if isinstance(value, (list, tuple)) else (value, value)


LengthSpan = Annotated[tuple[Length, Length], BeforeValidator(_span)]
AngleSpan = Annotated[tuple[Angle, Angle], BeforeValidator(_span)]
MassSpan = Annotated[tuple[Mass, Mass], BeforeValidator(_span)]
SpeedSpan = Annotated[tuple[Speed, Speed], BeforeValidator(_span)]
TimeSpan = Annotated[tuple[Time, Time], BeforeValidator(_span)]
Vector = tuple[Number, Number, Number]
Point = tuple[Length, Length, Length]
Color = tuple[
    Annotated[Share, Field(le=1)], Annotated[Share, Field(le=1)], Annotated[Share, Field(le=1)]
]


class Section(BaseModel):
    """A part of a document: immutable, and unknown keys are errors."""

    # Sections are built with the document that holds them, which halves the time to start.
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Document(Section):
    """The head that every document carries."""

    cbdsl: Literal[1]
    """Version of the document format."""
    name: Name
    """Name by which other documents refer to this one."""
    description: str = ""
    """What it is for, in a sentence or two."""

"""Base of all documents: strict, immutable sections with quantities in named units."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import (
    float_schema,
    int_schema,
    no_info_before_validator_function,
    plain_serializer_function_ser_schema,
    str_schema,
    tuple_schema,
    with_info_wrap_validator_function,
)

from cbdsl.types.relative import Unmeasured, is_relative
from cbdsl.types.unit import read_quantity

NAME_PATTERN = r"^[A-Za-z][A-Za-z0-9_]*$"


class ValueSchema:
    """Finished schema of a value: putting one together at each use takes longer."""

    def __init__(self, schema: CoreSchema) -> None:
        self.schema = schema

    def __get_pydantic_core_schema__(self, _: object, __: GetCoreSchemaHandler) -> CoreSchema:
        return {**self.schema}


def quantity(*dimensions: str, **limits: Any) -> ValueSchema:
    """Return the type of a number in SI or a text with a unit; limits are ``gt`` to ``le``."""
    read, number = partial(_quantity, dimensions=dimensions), float_schema(**limits)
    write = plain_serializer_function_ser_schema(written, when_used="json")
    return ValueSchema(with_info_wrap_validator_function(read, number, serialization=write))


def _quantity(
    value: Any,
    validate: Callable[[float], float],
    info: ValidationInfo,
    dimensions: tuple[str, ...],
) -> float:
    """Read a quantity; one in terms of a robot is not a number before there is that robot."""
    if info.context and info.context.get("relative") and is_relative(value):
        return Unmeasured(value)
    return validate(read_quantity(value, dimensions))


def written(value: float) -> float | str:
    """Return a quantity as a document writes it, in SI unless it is in terms of a robot."""
    return value.text if isinstance(value, Unmeasured) else value


def _several(part: ValueSchema, count: int) -> ValueSchema:
    return ValueSchema(tuple_schema([part.schema] * count))


def _span(part: ValueSchema) -> ValueSchema:
    """Return the type of a first and last value; a single value is both."""

    # A single value such as ``5 cm`` is a span whose ends are equal, so that nothing is drawn.
    def pair(value: Any) -> Any:
        return value if isinstance(value, (list, tuple)) else (value, value)

    return ValueSchema(no_info_before_validator_function(pair, _several(part, 2).schema))


def _named(element: str) -> ValueSchema:
    """Return the type of a name from the URDF; ``element`` is its XML element."""
    wanted = (
        f'the name of a {element}, as in <{element} name="..."> of the URDF, in quotes if a number'
    )

    # A URDF may name a link ``1``, which YAML reads as a number unless it is in quotes.
    def require_text(value: Any) -> Any:
        if isinstance(value, str):
            return value
        raise PydanticCustomError("not_named", "{expected}", {"expected": wanted})

    return ValueSchema(no_info_before_validator_function(require_text, str_schema()))


# Units are part of the types below. A text with a unit is converted to SI when the document is
# read, and a number without a unit is in SI already. All other code computes in SI.
_NUMBER, _SHARE = quantity(), quantity(ge=0, le=1)
_LENGTH, _ANGLE, _SPEED = quantity("length"), quantity("angle"), quantity("speed")
_TIME, _MASS = quantity("time", ge=0), quantity("mass", gt=0)
_SIZE = quantity("length", gt=0)

Name = Annotated[str, ValueSchema(str_schema(pattern=NAME_PATTERN))]
JointName = Annotated[str, _named("joint")]
LinkName = Annotated[str, _named("link")]
Count = Annotated[int, ValueSchema(int_schema(ge=0))]
PositiveCount = Annotated[int, ValueSchema(int_schema(gt=0))]
Number = Annotated[float, _NUMBER]
Positive = Annotated[float, quantity(gt=0)]
Length = Annotated[float, _LENGTH]
Size = Annotated[float, _SIZE]
Angle = Annotated[float, _ANGLE]
Time = Annotated[float, _TIME]
Duration = Annotated[float, quantity("time", gt=0)]
Rate = Annotated[float, quantity("rate", gt=0)]
Mass = Annotated[float, _MASS]
Force = Annotated[float, quantity("force")]
Torque = Annotated[float, quantity("torque")]
Speed = Annotated[float, _SPEED]
AngularSpeed = Annotated[float, quantity("angular speed")]
Tolerance = Annotated[float, quantity("length", "angle", "force", "torque", gt=0)]
AnySpeed = Annotated[float, quantity("speed", "angular speed", gt=0)]
AnyGain = Annotated[float, quantity("rate", "speed per force", gt=0)]
AnyAcceleration = Annotated[float, quantity("acceleration", "angular acceleration", gt=0)]
Coordinate = Annotated[float, quantity("length", "angle")]
Extent = Annotated[float, quantity("length", "angle", gt=0)]
Distance = Annotated[float, quantity("length", "angle", ge=0)]
Lever = Annotated[float, quantity("length", ge=0)]
NonNegative = Annotated[float, quantity(ge=0)]
Pixels = Annotated[float, quantity("pixels", gt=0)]

LengthSpan = Annotated[tuple[float, float], _span(_LENGTH)]
SizeSpan = Annotated[tuple[float, float], _span(_SIZE)]
AngleSpan = Annotated[tuple[float, float], _span(_ANGLE)]
MassSpan = Annotated[tuple[float, float], _span(_MASS)]
SpeedSpan = Annotated[tuple[float, float], _span(_SPEED)]
TimeSpan = Annotated[tuple[float, float], _span(_TIME)]
Vector = Annotated[tuple[float, float, float], _several(_NUMBER, 3)]
Point = Annotated[tuple[float, float, float], _several(_LENGTH, 3)]
Turn = Annotated[tuple[float, float, float], _several(_ANGLE, 3)]
Color = Annotated[tuple[float, float, float], _several(_SHARE, 3)]


class Section(BaseModel):
    """Part of a document: immutable, without unknown keys."""

    # An unknown key is an error: a misspelled optional key would otherwise have no effect.
    # Sections are built with the document that holds them, which halves the time to start.
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    renamed: ClassVar[Mapping[str, str]] = {}
    """Current names of the keys of older documents."""
    moved: ClassVar[Mapping[str, str]] = {}
    """Advice for keys of older documents that have no current name."""


class Document(Section):
    """Keys common to all documents."""

    cbdsl: Literal[1]
    """Version of the document format."""
    name: Name
    """Name by which other documents refer to this one."""
    description: str = ""
    """Purpose, in a sentence or two."""

    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Keys that are required without any of other ones, with these."""

    @classmethod
    def is_for_any_robot(cls, data: object) -> bool:
        """Return whether the values of a document may be in terms of a robot that it lacks."""
        return False

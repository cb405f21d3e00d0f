"""Units of settings whose dimension depends on the type of a feedback."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.types.relative import is_relative
from cbdsl.types.resource_type import ResourceType
from cbdsl.types.unit import QuantityError, dimensions_of, read_quantity
from cbdsl.yaml_text.source_map import SourceMap, Step

# Tasks move with the units of their types. Forces, torques and numbers, which nothing but joints
# changes, have the speeds of joints.
_SPEEDS = {"length": "speed", "angle": "angular speed"}
_ACCELERATIONS = {"length": "acceleration", "angle": "angular acceleration"}


def check_settings(
    kind: ResourceType,
    source: SourceMap,
    steps: tuple[Step, ...],
    diagnostics: Diagnostics,
    *,
    of_tips: bool = False,
) -> None:
    """Check the units of speed, acceleration and tolerance against a feedback's type.

    Args:
        kind: Type of the feedback.
        source: Source map of the document.
        steps: Path of the settings.
        diagnostics: Diagnostics so far.
        of_tips: True if the speed of a force may be the speed of the tip that exerts it.
    """
    dimensions = _dimensions(kind)
    speeds = _rates(dimensions, _SPEEDS)
    allowed: dict[tuple[str, ...], tuple[str, ...]] = {
        ("speed",): (*speeds, "speed") if of_tips and kind.name == "force" else speeds,
        ("acceleration",): _rates(dimensions, _ACCELERATIONS),
        ("arrival",): dimensions,
        ("quiescence", "tolerance"): dimensions,
        ("onset", "change"): dimensions,
        ("onset", "borne"): dimensions,
    }
    for keys, dimensions in allowed.items():
        path = (*steps, *keys)
        given = source.node(path).value if source.holds(*path) else "rest"
        # The type of the document checks a value in terms of a robot, once there is that robot.
        if given == "rest" or is_relative(given):
            continue
        try:
            read_quantity(given, dimensions)
        except QuantityError as error:
            diagnostics.add("CB506", source.place(*path), problem=str(error))


def _dimensions(kind: ResourceType) -> tuple[str, ...]:
    """Return the dimensions of a type's components, each once."""
    return tuple(
        dict.fromkeys(each for unit in kind.unit.split(", ") for each in dimensions_of(unit))
    )


def _rates(dimensions: tuple[str, ...], rates: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(rates[each] for each in dimensions if each in rates) or (rates["angle"],)

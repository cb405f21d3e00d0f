"""Setup: a stage as instructions for the person who arranges it."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

from cbdsl.extend.backend import PlaceSection, RobotDocument, StageDocument

Span = tuple[float, float]


def describe_setup(stage: StageDocument, context: str, robot: RobotDocument) -> str:
    """Return the arrangement that a context requires, one instruction a line."""
    return "\n".join(_lines(stage, context, robot))


def _lines(stage: StageDocument, context: str, robot: RobotDocument) -> Iterator[str]:
    yield f"stage '{stage.name}', context '{context}'; x, y, z in the frame of link '{robot.base}':"
    for name, fixture in stage.fixtures.items():
        x, y, z = (_span(span, "cm", 100.0) for span in fixture.position)
        yield f"- fixture '{name}' ({fixture.form.shape}) with its centre at {x}, {y}, {z}"
    for alias, presentation in stage.contexts[context].presentations.items():
        if not presentation.things or presentation.place is None:
            yield "- no object"
            continue
        shapes = [f"'{thing}' ({stage.things[thing].form.shape})" for thing in presentation.things]
        label = "" if alias is None else f"as '{alias}' "
        yield f"- object {' or '.join(shapes)} {label}{_place(presentation.place)}"


def _place(place: PlaceSection) -> str:
    """Return a place as a phrase."""
    frame = f" in the frame of the tip of '{place.hand}'" if place.hand else ""
    parts = [f"at x {_span(place.x, 'cm', 100)}, y {_span(place.y, 'cm', 100)}{frame}"]
    if place.beside is not None:
        parts = [f"{_span(place.beside.by, 'cm', 100)} beside '{place.beside.name}'"]
    if place.on is not None:
        parts.append(f"on '{place.on}'")
    if place.z is not None:
        parts.append(f"z {_span(place.z, 'cm', 100)}")
    if place.gap is not None:
        parts.append(f"{_span(place.gap, 'cm', 100)} above the tip")
    if place.yaw != (0.0, 0.0):
        parts.append(f"turned by {_span(place.yaw, 'deg', degrees(1.0))}")
    if place.held:
        parts.append("held by you")
    return ", ".join(parts)


def _span(span: Span, unit: str, factor: float) -> str:
    first, last = (f"{factor * value:.4g}" for value in span)
    return f"{first} {unit}" if first == last else f"{first} to {last} {unit}"

"""References of controllers: resources and literals that a feedback is compared with."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.checking.controller.axes import SPATIAL
from cbdsl.checking.controller.references import (
    HERE,
    LiteralError,
    RelativeText,
    is_literal,
    read_literal,
    read_relative,
)
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown, all_known
from cbdsl.program.controller import AlongNormals, Literal, Reference, Relative
from cbdsl.types.potential import PotentialType
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES

Written = str | float | tuple[str | float, ...]


class Comparison(NamedTuple):
    """Reference as written in the document.

    Attributes:
        resource: Resource that it names, or ``None`` for a literal or an unknown reference.
        literal: Quantities, if there are any; for a relative reference, its displacement.
        relative: Parts of a relative reference.
        axes: Axes along which the feedback is compared; ``None`` for all.
    """

    resource: Resource | None = None
    literal: Written | None = None
    relative: RelativeText | None = None
    axes: tuple[int, ...] | None = None

    def suits(self, feedback: Resource) -> bool:
        """Return whether a feedback can be compared with the reference; true if unknown."""
        if self.resource is not None and self.resource.type != feedback.type:
            return False
        if self.axes is not None and feedback.type.name not in SPATIAL:
            return False
        if self.literal is None:
            return True
        try:
            read_literal(self.literal, feedback, self.axes)
        except LiteralError:
            return False
        return True


def compared_with(potential: Outcome[PotentialType], feedback: Resource) -> Resource:
    """Return a feedback as its potential compares it, with the type that its reference needs."""
    if isinstance(potential, Unknown) or potential.compares is None:
        return feedback
    return feedback._replace(type=TYPES[potential.compares])


def read_comparison(
    context: ProgramContext,
    steps: Steps,
    value: Written | None,
    axes: tuple[int, ...] | None = None,
) -> Comparison:
    """Return the reference of a controller, and report unknown names.

    Args:
        context: Program context.
        steps: Path of the reference.
        value: Reference in the document.
        axes: Axes along which the feedback is compared; ``None`` for all.
    """
    if isinstance(value, tuple):
        items = [_item(context, (*steps, i), item) for i, item in enumerate(value)]
        known: Outcome[list[str | float]] = all_known(items)
        if isinstance(known, Unknown):
            return Comparison()
        return Comparison(literal=tuple(known), axes=axes)
    if not isinstance(value, str):
        return Comparison(literal=value, axes=axes)
    text = context.substitute(value, steps)
    if isinstance(text, Unknown):
        return Comparison()
    if is_literal(text):
        return Comparison(literal=text, axes=axes)
    relative = read_relative(text)
    if relative is None:
        named = context.resource(value, steps)
        return Comparison(None if isinstance(named, Unknown) else named, axes=axes)
    if relative.base == HERE:
        return Comparison(None, relative.offset, relative, axes)
    written = read_relative(value)
    base = context.resource(written.base if written else relative.base, steps)
    # An unknown base leaves the reference unknown.
    if isinstance(base, Unknown):
        return Comparison()
    return Comparison(base, relative.offset, relative, axes)


def _item(context: ProgramContext, steps: Steps, item: str | float) -> Outcome[str | float]:
    """Return a component with its parameters substituted."""
    return context.substitute(item, steps) if isinstance(item, str) else item


def compare(
    context: ProgramContext,
    steps: Steps,
    comparison: Comparison,
    feedback: Resource,
    diagnostics: Diagnostics,
) -> Outcome[Reference | None]:
    """Return a reference of the feedback's type, or ``None`` if there is none.

    Args:
        context: Program context.
        steps: Path of the controller.
        comparison: Reference as written.
        feedback: Compared feedback.
        diagnostics: Diagnostics so far.
    """
    base = comparison.resource
    if base is not None:
        typed = _of_its_type(context, steps, base, feedback, diagnostics)
        if isinstance(typed, Unknown) or comparison.relative is None:
            return typed
    if comparison.literal is None:
        return None
    literal = _in_its_units(context, steps, comparison, feedback, diagnostics)
    if comparison.relative is None or isinstance(literal, Unknown):
        return literal
    assert isinstance(literal, Literal)
    sign = comparison.relative.sign
    return Relative(base, tuple(sign * value for value in literal.values))


def _of_its_type(
    context: ProgramContext,
    steps: Steps,
    reference: Resource,
    feedback: Resource,
    diagnostics: Diagnostics,
) -> Outcome[Resource]:
    if reference.type == feedback.type:
        return reference
    body, source = context.body, context.source
    # ``look_at`` compares a pose with a position, and changes the type of its feedback to that end.
    own = body.resources.get(feedback.name, feedback)
    if own.type != feedback.type:
        diagnostics.add(
            "CB592",
            source.place(*steps, "reference"),
            names=[r.name for r in body.resources.values() if r.type == feedback.type],
            related=[(source.place(*steps, "feedback"), f"the feedback, {own.type}")],
            name=reference.name,
            reference_type=reference.type.apart_from(feedback.type),
            wanted=feedback.type.apart_from(reference.type),
        )
        return UNKNOWN
    others = (resource for resource in body.resources.values() if resource != feedback)
    diagnostics.add(
        "CB504",
        source.place(*steps, "reference"),
        names=[r.name for r in others if r.type == feedback.type],
        related=[
            (source.place(*steps, "feedback"), f"the feedback, {feedback.type}"),
            *(
                (body.declaration(resource), f"where '{resource.name}' comes from")
                for resource in (reference, feedback)
            ),
        ],
        name=reference.name,
        reference_type=reference.type.apart_from(feedback.type),
        feedback=feedback.name,
        feedback_type=feedback.type.apart_from(reference.type),
    )
    return UNKNOWN


def _in_its_units(
    context: ProgramContext,
    steps: Steps,
    comparison: Comparison,
    feedback: Resource,
    diagnostics: Diagnostics,
) -> Outcome[Literal | AlongNormals]:
    source, steps = context.source, (*steps, "reference")
    assert comparison.literal is not None
    try:
        return read_literal(comparison.literal, feedback, comparison.axes)
    except LiteralError as error:
        from cbdsl.yaml_text.comma import decimal_comma  # only a fault needs it

        comma = decimal_comma(source.node(steps))
        if comma is not None and error.code == "CB505":
            diagnostics.add("CB506", source.place(*steps), problem=comma)
            return UNKNOWN
        whole = error.item is None or comparison.relative is not None
        item = () if whole else (error.item,)
        diagnostics.add(error.code, source.place(*steps, *item), **error.details)
        return UNKNOWN

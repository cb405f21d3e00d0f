"""References of controllers: resources and literals that a feedback is compared with."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.checking.context import ProgramContext, Steps
from cbdsl.checking.controller.references import LiteralError, is_literal, read_literal
from cbdsl.checking.findings import Findings
from cbdsl.checking.lookup.scope import Scope
from cbdsl.program.controller import AlongNormals, Literal, Reference
from cbdsl.types.resource import Resource

Written = str | float | tuple[str | float, ...]


class Comparison(NamedTuple):
    """A reference as it is written.

    Attributes:
        resource: what it names, if that is known.
        literal: its quantities, where it has some.
    """

    resource: Resource | None = None
    literal: Written | None = None

    def suits(self, feedback: Resource) -> bool:
        """Whether a feedback can be compared with it, as far as anybody knows."""
        if self.resource is not None:
            return self.resource.type == feedback.type
        if self.literal is None:
            return True
        try:
            read_literal(self.literal, feedback)
        except LiteralError:
            return False
        return True


def read_comparison(
    context: ProgramContext, steps: Steps, value: Written | None, scope: Scope
) -> Comparison:
    """The reference of a controller; what it names and nobody knows is reported.

    Args:
        context: the program.
        steps: path of the reference.
        value: the reference in the document.
        scope: values of the program's and the controller's parameters.
    """
    if not isinstance(value, str):
        return Comparison(literal=value)
    text = context.substitute(value, steps, scope)
    if text is None:
        return Comparison()
    if is_literal(text):
        return Comparison(literal=text)
    return Comparison(context.resource(value, steps, scope))


def compare(
    context: ProgramContext,
    steps: Steps,
    comparison: Comparison,
    feedback: Resource,
    findings: Findings,
) -> Reference | None:
    """A reference of the feedback's type, or ``None`` where there is none.

    Args:
        context: the program.
        steps: path of the controller.
        comparison: its reference.
        feedback: what is compared.
        findings: where findings go.
    """
    if comparison.resource is not None:
        return _of_its_type(context, steps, comparison.resource, feedback, findings)
    if comparison.literal is not None:
        return _in_its_units(context, steps, comparison.literal, feedback, findings)
    return None


def _of_its_type(
    context: ProgramContext,
    steps: Steps,
    reference: Resource,
    feedback: Resource,
    findings: Findings,
) -> Resource | None:
    if reference.type == feedback.type:
        return reference
    body, source = context.body, context.source
    others = (resource for resource in body.resources.values() if resource != feedback)
    findings.add(
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
        reference_type=reference.type,
        feedback=feedback.name,
        feedback_type=feedback.type,
    )
    return None


def _in_its_units(
    context: ProgramContext, steps: Steps, literal: Written, feedback: Resource, findings: Findings
) -> Literal | AlongNormals | None:
    source, steps = context.source, (*steps, "reference")
    try:
        return read_literal(literal, feedback)
    except LiteralError as error:
        from cbdsl.yaml_text.comma import decimal_comma  # only a fault needs it

        comma = decimal_comma(source.node(steps))
        if comma is not None and error.code == "CB505":
            findings.add("CB506", source.place(*steps), problem=comma)
            return None
        item = () if error.item is None else (error.item,)
        findings.add(error.code, source.place(*steps, *item), **error.details)
        return None

"""References relative to the activation, and loads whose change a controller waits for."""

from __future__ import annotations

from cbdsl.checking.load_noise import least_force
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.documents import program as written
from cbdsl.program.controller import Reference, Relative
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import FingerLoad, NetLoad, Resource


def check_relative(
    context: ProgramContext,
    steps: Steps,
    document: written.ControllerSection,
    reference: Reference | None,
    feedback: Resource,
) -> bool:
    """Return whether a relative reference and an onset are valid, and report their errors.

    Args:
        context: Program context.
        steps: Path of the controller.
        document: Controller section.
        reference: Reference, or ``None`` if there is none.
        feedback: Feedback of the controller.
    """
    is_here = isinstance(reference, Relative) and reference.base is None
    problem = _problem(document, reference, is_here=is_here)
    if problem:
        context.add("CB583", context.source.place(*steps, "reference"), problem=problem)
    fault = document.onset is not None and reference is not None and _fault(reference, feedback)
    if fault:
        context.add("CB584", context.source.key(*steps, "onset"), problem=fault)
    faint = "" if fault else _faint(context, document, feedback)
    if faint:
        context.add("CB595", context.source.place(*steps, "onset", "change"), problem=faint)
    return not (problem or fault or faint)


def _faint(context: ProgramContext, document: written.ControllerSection, feedback: Resource) -> str:
    """Return why the load cells' noise hides an onset's change of force; empty if it does not."""
    if document.onset is None or feedback.type.name != "force" or not context.has_body:
        return ""
    change, least = document.onset.change, least_force(context.body.document)
    if not 0.0 < change <= least:
        return ""
    return f"{change:g} N is within the noise of the load cells, {least:g} N"


def _problem(
    document: written.ControllerSection, reference: Reference | None, *, is_here: bool
) -> str:
    """Return the error of a relative reference, as a clause; empty if there is none."""
    if is_here and document.standoff is not None:
        return "a tip cannot stand off from 'here', where it is itself"
    potential = POTENTIALS.get(document.potential)
    if is_here and potential is not None:
        if potential.field:
            return "a field is solved for before it is known where 'here' is"
        if potential.compares is not None:
            return f"'here' is not a {potential.compares}, which {potential.name} requires"
    base = reference.base if isinstance(reference, Relative) else None
    if base is not None and base.is_drawn:
        return f"'{base.name}' is random, and a random reference cannot be displaced"
    return ""


def _fault(reference: Reference, feedback: Resource) -> str:
    """Return the error of an onset, as a clause; empty if there is none."""
    loads = (NetLoad, FingerLoad)
    if not isinstance(feedback.source, loads) or feedback.type.name == "wrench":
        return f"'{feedback.name}' is neither a force nor a torque of a hand or a finger"
    if not (isinstance(reference, Relative) and reference.base is None and any(reference.offset)):
        return "the load changes from 'here' towards a reference such as 'here - 2 N'"
    return ""

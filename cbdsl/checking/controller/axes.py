"""World axes along which a controller compares, and contradictions between them."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.checking.knowledge.impossible_states import is_mostly_defined
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents import program as written
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller
from cbdsl.program.dry_run import levels
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import Combination, record_of

AXES = "xyz"

#: Types whose components are those of a vector in the world frame.
SPATIAL = ("position", "force", "torque", "offset")
# Potentials that compare each component by itself.
_BY_COMPONENTS = ("spring", "at_most", "at_least")
# Types whose controllers, if they state no axes, take all three from the levels below.
_WHOLE = ("position", "force")


def read_axes(document: written.ControllerSection) -> tuple[int, ...] | None:
    """Return the axes that a controller compares along, in order; ``None`` for all."""
    axes = tuple(i for i, axis in enumerate(AXES) if axis in (document.axes or AXES))
    return None if len(axes) == len(AXES) else axes


def fill_axes(
    context: ProgramContext, steps: Steps, document: written.ControllerSection
) -> written.ControllerSection:
    """Return a controller section with axes substituted for its parameters.

    A value that is not an axis is reported, and an unused axis replaces it.
    """
    if document.axes is None or set(document.axes) <= set(AXES):
        return document
    filled: list[str] = []
    for place, text in enumerate(document.axes):
        at = (*steps, "axes", place)
        value = context.substitute(text, at)
        if not isinstance(value, Unknown) and value not in AXES:
            problem = f"unknown axis '{value}'; allowed are x, y and z"
            context.add("CB580", context.source.place(*at), problem=problem)
        # A replacement keeps the number of axes, so that the components of the reference can be
        # checked.
        if isinstance(value, Unknown) or value not in AXES:
            value = next((axis for axis in AXES if axis not in (*document.axes, *filled)), AXES[-1])
        filled.append(value)
    return document.model_copy(update={"axes": tuple(filled)})


def check_axes(
    context: ProgramContext, steps: Steps, document: written.ControllerSection, feedback: Resource
) -> bool:
    """Return whether a controller's axes make sense for its feedback, and report the errors."""
    axes = document.axes
    if axes is None:
        return True
    place = context.source.place(*steps, "axes")
    if not axes or len(set(axes)) < len(axes):
        twice = next((axis for axis in axes if axes.count(axis) > 1), None)
        problem = f"'{twice}' is given twice" if twice else "an empty list leaves nothing to do"
        context.add("CB580", place, problem=problem)
        return False
    key = context.source.key(*steps, "axes")
    along_normals = isinstance(document.reference, str) and "along normals" in document.reference
    if document.potential not in POTENTIALS:
        return True  # an unknown potential says nothing about axes
    if document.potential not in _BY_COMPONENTS:
        problem = f"a {document.potential} potential is a function of its whole feedback"
    elif feedback.type.name not in SPATIAL:
        problem = f"'{feedback.name}' is of type {feedback.type}"
    elif along_normals:
        problem = "forces along normals have directions of their own"
    elif document.funnel is not None:
        problem = "a funnel raises what is compared along all of them"
    else:
        return True
    context.add("CB581", key, problem=problem)
    return False


def check_contradictions(
    context: ProgramContext, program: CheckedProgram, actions: Mapping[str, Steps]
) -> None:
    """Report actions in which two controllers state an axis that only one of them can have.

    Args:
        context: Context of the program's document.
        program: Checked program.
        actions: Paths of its actions in the document, by name.
    """
    reported: set[tuple[str, str]] = set()
    for action in program.actions:
        own = [level.controller for level in levels(program, action) if not level.background]
        for place, above in enumerate(own):
            for below in own[place + 1 :]:
                pair = above.name, below.name
                shared = _shared(above, below)
                if shared and pair not in reported:
                    reported.add(pair)
                    context.add(
                        "CB582",
                        context.source.place(*actions[action.name]),
                        above=above.name,
                        below=below.name,
                        axes=" and ".join(AXES[axis] for axis in sorted(shared)),
                    )


def _shared(above: Controller, below: Controller) -> set[int]:
    """Return the axes that two controllers both state for the same joints, but cannot share."""
    # Two controllers that state an axis for common joints cannot share it: the upper one always
    # decides. A force above a position is exempt, because it is undefined before contact and leaves
    # the axis to the position until then.
    if below.axes is None or (above.axes is None and above.feedback.type.name not in _WHOLE):
        return set()
    if _are_apart(above.feedback, below.feedback):
        return set()
    if "torque" in (above.feedback.type.name, below.feedback.type.name):
        return set()
    if set(above.joints).isdisjoint(below.joints) or _takes_over(above, below):
        return set()
    return set(range(len(AXES)) if above.axes is None else above.axes) & set(below.axes)


def _are_apart(one: Resource, other: Resource) -> bool:
    """Return whether two feedbacks of tips are independent: their centroid and their separation."""
    # The mean and the difference of two positions are independent coordinates.
    return {record_of(each.source).combines for each in (one, other)} == set(Combination)


def _takes_over(above: Controller, below: Controller) -> bool:
    """Return whether the upper controller may be undefined while the lower one is defined."""
    if above.onset is not None or above.requires != below.requires:
        return True
    return above.feedback != below.feedback and not is_mostly_defined(above)

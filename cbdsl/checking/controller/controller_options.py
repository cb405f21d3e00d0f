"""Options of a controller: whether they apply to its feedback, and their units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple, TypeVar

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.robot.limits import is_of_another_kind
from cbdsl.checking.robot.settings import check_settings
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome
from cbdsl.documents import program as written
from cbdsl.documents.robot import QuiescenceSection, TaskSettings
from cbdsl.program.controller import Quiescence
from cbdsl.types.casts import FEATURES
from cbdsl.types.modifier import declared
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES, ResourceType
from cbdsl.types.source_record import Normals, normals_of, owner_of

MANIPULABILITY = "manipulability"
LOOK_AT = "look_at"


class ControllerSettings(NamedTuple):
    """Settings of one controller; its own settings override the robot's.

    ``arrival`` and ``tip_stiffness`` have the meaning of the fields of ``Controller``.
    """

    gain: float
    speed: float | None
    acceleration: float | None
    quiescence: Quiescence
    arrival: tuple[float, ...]
    tip_stiffness: float | None = None


class Misplaced(NamedTuple):
    """Option that does not apply where it is written.

    Attributes:
        path: Path of the option below its controller.
        purpose: Purpose of the option.
        instead: Actual feedback or potential, as a clause.
    """

    path: Steps
    purpose: str
    instead: str


def misplaced(document: written.ControllerSection, feedback: Resource) -> Iterator[Misplaced]:
    """Yield the options that do not apply to a feedback or to the potential."""
    instead = f"the feedback is '{feedback.name}', {feedback.type}"
    for modifier, _ in declared(document):
        if not modifier.suits(feedback, document.potential):
            yield Misplaced((modifier.name,), modifier.purpose, instead)
    if document.manipulator is not None and document.potential != MANIPULABILITY:
        potential = f"the potential is {document.potential}"
        yield Misplaced(("manipulator",), f"the potential {MANIPULABILITY}", potential)
    # Only fingers flex.
    seek = document.seek
    of_palms = normals_of(feedback) is Normals.PALMS
    if of_palms and seek is not None and seek.until is not None:
        yield Misplaced(("seek", "until"), "forces of fingers", instead)


def check_options(
    context: ProgramContext,
    steps: Steps,
    document: written.ControllerSection,
    feedback: Resource,
    diagnostics: Diagnostics,
) -> None:
    """Check that options apply to a feedback, and have its units.

    Args:
        context: Program context.
        steps: Path of the controller.
        document: Controller section.
        feedback: Feedback of the controller.
        diagnostics: Diagnostics so far.
    """
    for option in misplaced(document, feedback):
        place = context.source.key(*steps, *option.path)
        details = {"name": option.path[-1], "purpose": option.purpose, "instead": option.instead}
        diagnostics.add("CB513", place, **details)
    check_settings(_task(document, feedback), context.source, steps, diagnostics, of_tips=True)
    if normals_of(feedback) is Normals.FINGERS and document.seek is not None:
        _check_end(context, (*steps, "seek", "until"), owner_of(feedback.source), diagnostics)


def _check_end(context: ProgramContext, steps: Steps, hand: str, diagnostics: Diagnostics) -> None:
    """Check that the end of a search has the unit of the joints that close the fingers."""
    model, robot = context.body.model, context.body.document
    if model is None or not context.source.holds(*steps):
        return
    node = context.source.node(steps)
    for cell in robot.load_cells[hand].values():
        joint = model.joints.get(cell.joint)
        if joint is not None and is_of_another_kind(node.value, joint.unit):
            diagnostics.add("CB590", node.place, text=node.value, name=cell.joint, unit=joint.unit)
            return


def settings_of(
    context: ProgramContext, steps: Steps, document: written.ControllerSection, feedback: Resource
) -> Outcome[ControllerSettings]:
    """Return the controller's settings, completed by the robot's; unknown if some are missing."""
    if feedback.type.name in FEATURES or document.potential not in POTENTIALS:
        return UNKNOWN
    robot = context.body.document
    task = _task(document, feedback).name
    general = robot.control.tasks.get(task)
    candidates: list[written.ControllerSection | TaskSettings] = [document]
    if general is not None:
        candidates.append(general)
    # A section of the controller replaces that of the robot as a whole: quiescences are not merged.
    gain = _first(settings.gain for settings in candidates)
    quiescence = _first(settings.quiescence for settings in candidates)
    if gain is None or quiescence is None:
        if not TYPES.keys() >= robot.control.tasks.keys():
            return UNKNOWN  # a misspelt task may be the one
        lacking = {"a gain": gain, "a quiescence": quiescence}
        setting = " and ".join(name for name, value in lacking.items() if value is None)
        details = {"robot": robot.name, "setting": setting, "task": task}
        context.add("CB511", context.source.key(*steps), **details)
        return UNKNOWN
    return ControllerSettings(
        gain,
        _first(settings.speed for settings in candidates),
        _first(settings.acceleration for settings in candidates),
        Quiescence(quiescence.rate, quiescence.window, quiescence.within, quiescence.tolerance),
        _arrival(document, general, _task(document, feedback)),
    )


def _arrival(
    document: written.ControllerSection, general: TaskSettings | None, task: ResourceType
) -> tuple[float, ...]:
    """Return the largest residuals at which a controller at rest has arrived.

    A bound of quiescence is a tolerance, too; beyond it the controller is not at rest.
    """
    if document.arrival == "rest" or not POTENTIALS[document.potential].reference:
        return (math.inf,)
    stated = [document.arrival, _bound(document.quiescence)]
    if general is not None:
        stated += [general.arrival, None if document.quiescence else _bound(general.quiescence)]
    tolerance = _first(stated)
    return task.arrivals if tolerance is None else (tolerance,)


def _bound(quiescence: QuiescenceSection | None) -> float | None:
    """Return the largest residual at rest; infinite if a share of the reference bounds it."""
    if quiescence is None or quiescence.tolerance is not None:
        return None if quiescence is None else quiescence.tolerance
    return None if quiescence.within is None else math.inf


def _task(document: written.ControllerSection, feedback: Resource) -> ResourceType:
    """Return the type that a controller's settings are for."""
    potential = POTENTIALS.get(document.potential)
    # ``look_at`` reads a pose and reduces an angle, so that it has the settings of an orientation.
    name = potential.task if potential else None
    return feedback.type if name is None else TYPES[name]


T = TypeVar("T")


def _first(values: Iterable[T | None]) -> T | None:
    """Return the first value that is set."""
    return next((value for value in values if value is not None), None)

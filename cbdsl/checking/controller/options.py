"""The options of a controller: whether they mean something for its feedback, and in which units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple, TypeVar

from cbdsl.checking.context import ProgramContext, Steps
from cbdsl.checking.findings import Findings
from cbdsl.checking.robot.settings import check_settings
from cbdsl.documents import program as written
from cbdsl.documents.robot import TaskSettings
from cbdsl.program.controller import Quiescence
from cbdsl.types.resource import FingerForces, NetForces, Resource, Tip
from cbdsl.types.resource_type import TYPES

MANIPULABILITY = "manipulability"


class ControllerSettings(NamedTuple):
    """Settings of one controller, its own before the robot's."""

    gain: float
    speed: float | None
    acceleration: float | None
    quiescence: Quiescence


def misplaced(document: written.ControllerSection, feedback: Resource) -> Iterator[Steps]:
    """Paths of the options that mean nothing for a feedback."""
    is_position = isinstance(feedback.source, Tip) and feedback.type.name == "position"
    is_of_hands = isinstance(feedback.source, NetForces)
    meaningful = {
        "free_axis": feedback.type.name == "orientation",
        "standoff": is_position,
        "funnel": is_position,
        "seek": isinstance(feedback.source, FingerForces) or is_of_hands,
        "manipulator": document.potential == MANIPULABILITY,
    }
    for key, fits in meaningful.items():
        if getattr(document, key) is not None and not fits:
            yield (key,)
    # Only fingers flex.
    if is_of_hands and document.seek is not None and document.seek.until is not None:
        yield ("seek", "until")


def check_options(
    context: ProgramContext,
    steps: Steps,
    document: written.ControllerSection,
    feedback: Resource,
    findings: Findings,
) -> None:
    """Check that options mean something for a feedback, and have its units.

    Args:
        context: the program.
        steps: path of the controller.
        document: the controller.
        feedback: what it measures.
        findings: where findings go.
    """
    for path in misplaced(document, feedback):
        place = context.source.key(*steps, *path)
        findings.add("CB513", place, name=path[-1], feedback=feedback.type)
    check_settings(feedback.type.name, context.source, steps, findings)


def settings_of(
    context: ProgramContext, steps: Steps, document: written.ControllerSection, feedback: Resource
) -> ControllerSettings | None:
    """The controller's own settings, and the robot's for the rest; ``None`` where some lack."""
    robot = context.body.document
    general = robot.control.tasks.get(feedback.type.name)
    candidates: list[written.ControllerSection | TaskSettings] = [document]
    if general is not None:
        candidates.append(general)
    gain = _first(settings.gain for settings in candidates)
    quiescence = _first(settings.quiescence for settings in candidates)
    if gain is None or quiescence is None:
        if not TYPES.keys() >= robot.control.tasks.keys():
            return None  # one of them is misspelt, which has been reported
        lacking = {"a gain": gain, "a quiescence": quiescence}
        setting = " and ".join(name for name, value in lacking.items() if value is None)
        details = {"robot": robot.name, "setting": setting, "task": feedback.type.name}
        context.add("CB511", context.source.key(*steps), **details)
        return None
    return ControllerSettings(
        gain,
        _first(settings.speed for settings in candidates),
        _first(settings.acceleration for settings in candidates),
        Quiescence(quiescence.rate, quiescence.window, quiescence.within, quiescence.tolerance),
    )


T = TypeVar("T")


def _first(values: Iterable[T | None]) -> T | None:
    """The first value that is set."""
    return next((value for value in values if value is not None), None)

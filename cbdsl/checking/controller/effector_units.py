"""Force tasks in the units of the tip that they move: speeds in m/s, gains in m/s per N."""

from __future__ import annotations

from cbdsl.checking.controller.controller_options import ControllerSettings
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome
from cbdsl.documents.robot import RobotDocument
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import is_pressed, owner_of, record_of
from cbdsl.types.unit import QuantityError, parse_quantity

# Dimension of each setting in the units of a moved tip.
_OF_TIPS = {"gain": "speed per force", "speed": "speed"}
# Name and unit of the type of joints that slide.
_SLIDING = ("configuration", "m")


def in_task_units(
    context: ProgramContext,
    steps: Steps,
    settings: ControllerSettings,
    feedback: Resource,
    effector: Resource,
) -> Outcome[ControllerSettings]:
    """Return the settings in the units of the task; unknown if their units are invalid.

    A tip that moves by dx changes its force by K dx, with the stiffness K of the robot's document.
    For the force of a hand, K is multiplied by the number of fingers. A spring moves by half its
    error, so that a gain of g m/s per N equals a gain of 2 K g per second.
    """
    written = {key: value for key in _OF_TIPS if (value := _of_tips(context, steps, key))}
    # It is the task's own, or that of joints that slide.
    if feedback.type.name != "force" or (effector.type.name, effector.type.unit) == _SLIDING:
        written.pop("speed", None)
    if not written:
        return settings
    problem = _problem(feedback, effector)
    for key, value in written.items():
        if problem:
            place = context.source.place(*steps, key)
            context.add("CB594", place, value=value, problem=problem)
    if problem:
        return UNKNOWN
    stiffness = _stiffness(context.body.document, feedback)
    if "gain" in written:
        settings = settings._replace(gain=2.0 * stiffness * settings.gain)
    return settings._replace(tip_stiffness=stiffness) if "speed" in written else settings


def _stiffness(robot: RobotDocument, feedback: Resource) -> float:
    """Return the change of a force per tip displacement, N/m; each fingertip is a spring."""
    source, fingers = feedback.source, 1
    if record_of(source).sums:
        fingers = len(robot.load_cells[robot.members(owner_of(source))[0]])
    # Fingers are springs in parallel, whose stiffnesses add up.
    return fingers * robot.control.contact_stiffness


def _of_tips(context: ProgramContext, steps: Steps, key: str) -> str | None:
    """Return a setting as written if it has the unit of a tip, else ``None``."""
    if not context.source.holds(*steps, key):
        return None
    value = context.source.node((*steps, key)).value
    try:
        unit = parse_quantity(value)[1] if isinstance(value, str) else None
    except QuantityError:
        return None
    return str(value) if unit is not None and unit.dimension == _OF_TIPS[key] else None


def _problem(feedback: Resource, effector: Resource) -> str:
    """Return why a force does not change as a tip moves, as a clause; empty if it does."""
    if feedback.type.name != "force" or not is_pressed(feedback.source):
        return f"'{feedback.name}' is not a force of a finger or a hand that an arm presses with"
    if effector.type.name != "position":
        return f"'{effector.name}' is a {effector.type}, and moves in {effector.type.unit}"
    return ""

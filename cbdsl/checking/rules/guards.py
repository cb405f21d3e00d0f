"""Guards of a program: loads that are measured beyond noise, distances that the start keeps."""

from __future__ import annotations

from cbdsl.checking.load_noise import least_force
from cbdsl.checking.program_context import ProgramContext
from cbdsl.checking.start_clearance import unkept_clearance


def check_guards(context: ProgramContext) -> None:
    """Report bounds that noise alone exceeds, and bounds of a robot without load cells."""
    guards, source = context.document.guards, context.source
    if not context.has_body:
        return
    robot = context.body.document
    _check_joint_torque(context)
    _check_clearance(context)
    # Loads up to this force are taken for noise, so that a lower bound could not be enforced.
    least = least_force(robot)
    for key in ("finger_force", "hand_force"):
        bound = getattr(guards, key)
        if bound is None:
            continue
        place = source.place("guards", key)
        if not robot.load_cells:
            problem = f"'{robot.name}' has no load cells to measure it"
            context.add("CB587", place, problem=problem)
        elif 0 < bound <= least:
            problem = f"{bound:g} N is within the noise of its load cells, {least:g} N"
            context.add("CB587", place, problem=problem)


def _check_joint_torque(context: ProgramContext) -> None:
    """Report a bound on torques that no joint measures, or that motion alone exceeds."""
    robot, bound = context.body.document, context.document.guards.joint_torque
    if bound is None:
        return
    place, settings = context.source.place("guards", "joint_torque"), robot.joint_torques
    if settings is None:
        problem = f"the drives of '{robot.name}' measure no torques ('joint_torques')"
        context.add("CB587", place, problem=problem)
    elif 0 < bound <= settings.threshold:
        least = f"{settings.threshold:g} N m"
        problem = f"motion without contact may cause up to {least}, and the bound is {bound:g} N m"
        context.add("CB587", place, problem=problem)


def _check_clearance(context: ProgramContext) -> None:
    """Report a distance that links do not keep in the start posture."""
    least, model = context.document.guards.clearance, context.body.model
    if least is None or model is None:
        return
    if problem := unkept_clearance(context.body.document, model, least):
        context.add("CB587", context.source.place("guards", "clearance"), problem=problem)

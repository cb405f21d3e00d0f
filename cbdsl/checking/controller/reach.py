"""Constant references that are out of the robot's reach."""

from __future__ import annotations

import math

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.program.controller import Literal
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import Carrier, Combination, owner_of, record_of

# Angles that are periodic: a whole turn more is the same orientation.
_TURNED = ("orientation", "heading")


def check_reach(
    context: ProgramContext, steps: Steps, reference: Literal, feedback: Resource
) -> None:
    """Warn of positions that are farther away than the links are long, and of degrees as radians.

    Args:
        context: Program context.
        steps: Path of the reference.
        reference: Reference in SI units, with as many components as the feedback.
        feedback: Feedback that has to reach it.
    """
    place = context.source.place(*steps)
    name, values = feedback.type.name, reference.values
    if name in _TURNED:
        angle = max(values, key=abs)
        if abs(angle) > 2 * math.pi:
            context.add("CB719", place, angle=f"{angle:g}")
    if name != "position":
        return
    farthest = _farthest(context.body, feedback)
    distance = max(math.hypot(*values[i : i + 3]) for i in range(0, len(values), 3))
    if farthest is not None and distance > farthest:
        ends = {"distance": f"{distance:.4g}", "farthest": f"{farthest:.3g}"}
        context.add("CB718", place, name=feedback.name, **ends)


def farthest_tip(body: CheckedRobot) -> float | None:
    """Return a bound on the distance of any tip from the base, m, or ``None`` without one."""
    tipped = [name for name, effector in body.document.effectors.items() if effector.tip]
    reaches = [_reaches(body, name) for name in tipped]
    return max((max(each) for each in reaches), default=None) if all(reaches) else None


def _farthest(body: CheckedRobot, feedback: Resource) -> float | None:
    """Return a bound on the norm of a position that joints determine, m, or ``None``."""
    source = feedback.source
    record = record_of(source)
    if Carrier.TIPS not in record.carriers:
        return None
    reaches = _reaches(body, owner_of(source))
    if record.combines is Combination.DIFFERENCE:
        return sum(reaches) or None
    return max(reaches, default=None)


# By the triangle inequality, no posture moves a tip farther from the base than the sum of the link
# lengths between them. Limits of angles and collisions are ignored: an unreachable position may
# pass, and a reachable one is never reported. The mean of several tips is within the largest bound.
# The difference of two tips is within the sum of both.
def _reaches(body: CheckedRobot, effector: str) -> list[float]:
    """Return a bound on each member tip's distance from the base, m; empty if one has none."""
    robot, model, reaches = body.document, body.model, []
    for member in robot.members(effector):
        tip = robot.effectors[member].tip
        if tip is None or model is None or not model.links.issuperset((robot.base, tip.link)):
            return []
        links = model.reach(robot.base, tip.link)
        if links is None:
            return []
        reaches.append(links + math.hypot(*tip.offset))
    return reaches

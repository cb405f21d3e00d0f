"""Controllers that cannot work although their types fit."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cbdsl.checking.controller.reach import check_reach
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.robot.limits import limit_details
from cbdsl.checking.robot.robot_constants import check_signs
from cbdsl.diagnostics.counting import count
from cbdsl.documents import program as written
from cbdsl.program.controller import AlongNormals, Literal, Reference
from cbdsl.types.modifier import declared
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import configured


def check_numbers(
    context: ProgramContext, steps: Steps, document: written.ControllerSection
) -> None:
    """Check the signs and relations of the numbers of a controller's modifiers."""
    for modifier, section in declared(document):
        own = (*steps, modifier.name)
        positive: list[Steps] = [(option,) for option in modifier.positive]
        not_negative: list[Steps] = [(option,) for option in modifier.not_negative]
        check_signs(section, context.source, own, positive, not_negative, context.diagnostics)
        fault = modifier.fault(section)
        if fault is not None:
            context.add(fault.code, context.source.place(*own, fault.option), **fault.details)


def check_reference(
    context: ProgramContext, steps: Steps, reference: Reference | None, feedback: Resource
) -> None:
    """Check a constant reference against the possible values of the feedback."""
    steps = (*steps, "reference")
    if isinstance(reference, AlongNormals) and reference.force < 0:
        place = context.source.place(*steps)
        context.add("CB208", place, problem="a finger can press along its normal, and cannot pull")
    if isinstance(reference, Literal):
        check_reach(context, steps, reference, feedback)
    if isinstance(reference, Literal) and (effector := configured(feedback.source)):
        joints = context.body.document.joints(effector)
        limits = context.body.limits(joints)
        for i, (joint, angle, span) in enumerate(
            zip(joints, reference.values, limits, strict=True)
        ):
            if span is not None and not span[0] <= angle <= span[1]:
                node = context.source.node((*steps, i))
                limits_text = limit_details(node.value, angle, span, feedback.type.units[i])
                context.add("CB517", node.place, joint=joint, **limits_text)


def suits_body(
    context: ProgramContext,
    steps: Steps,
    document: written.ControllerSection,
    feedback: Resource,
    effector: Resource,
) -> bool:
    """Return whether the body meets the needs of a potential, and report unmet ones."""
    place = context.source.place(*steps, "feedback")
    problems = list(_problems(context, document, feedback, effector))
    for problem in problems:
        context.add("CB519", place, potential=document.potential, problem=problem)
    return not problems


def _problems(
    context: ProgramContext,
    document: written.ControllerSection,
    feedback: Resource,
    effector: Resource,
) -> Iterator[str]:
    if document.potential == "localizability":
        yield from _sight(context)
    own = configured(feedback.source)
    if not own:
        return
    moved = context.body.effector_joints(effector)
    if document.potential == "range":
        yield from _ranges(context, own, moved)
    # The measure of manipulability is sqrt(det(J J^T)) (Eq 3.5). With more rows than joints, J J^T
    # is singular in every posture, and the measure is 0 everywhere.
    if document.potential == "manipulability":
        members = context.body.document.members(own)
        rows = len(members) * (6 if document.manipulator == "pose" else 3)
        if rows > len(moved):
            tip = f"{count(len(moved), 'joint')} cannot move {count(rows, 'component')} of a tip"
            yield f"{tip}: it is 0 everywhere"


def _ranges(context: ProgramContext, effector: str, moved: tuple[str, ...]) -> Iterator[str]:
    joints = context.body.document.joints(effector)
    if joints != moved:
        yield f"it applies to the joints of '{effector}', but others are moved"
    spans = dict(zip(joints, context.body.limits(joints), strict=True))
    for joint, span in spans.items():
        # The potential divides by the range of each joint, and its minimum is in the middle
        # (Eq 3.4). A joint that turns without end has nothing to keep away from.
        if span is not None and not span[0] < span[1]:
            yield f"joint '{joint}' has no limits with a middle between them"
    known = [span for span in spans.values() if span is not None]
    if known and not any(math.isfinite(span[1] - span[0]) for span in known):
        yield f"no joint of '{effector}' has limits"


def _sight(context: ProgramContext) -> Iterator[str]:
    links = [camera.link for camera in context.body.document.main_cameras.values()]
    # Triangulation needs a baseline: cameras in one place see an object in the same direction at
    # any distance.
    if len(set(links)) < len(links):
        yield "both cameras are in the same place"

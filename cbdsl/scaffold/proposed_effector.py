"""Effectors of a proposed robot: tips, postures and values, as lines of its document."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from cbdsl.diagnostics.legible_text import legible
from cbdsl.kinematics.ready_posture import ReadyPosture
from cbdsl.robot.link_place import PLACING, at_first
from cbdsl.robot.semantic_groups import SemanticGroup
from cbdsl.robot.tip_frame import is_acting, tip_offset
from cbdsl.robot.urdf import Numbers, UrdfJoint, UrdfModel
from cbdsl.scaffold.document_template import scalar
from cbdsl.scaffold.hand import ProposedHand
from cbdsl.scaffold.start_contacts import Postures
from cbdsl.scaffold.tip_link import hand_corners, working_frame

# Distances of a tip before a thing, in parts of the limb's length.
_BEFORE = (0.02, 0.15)
# Part of a hand's way by which an open one may be less open, and time of the way in a search, s.
_SLACK, _PROBING = 0.05, 2.0
# Rotation of a limb at its first joint for a posture beside the first posture, rad.
_ASIDE = math.radians(30)
_TIP = "  # The frame that has a position and an orientation; its offset is in the link's frame."


def offset_of_tip(model: UrdfModel, effector: SemanticGroup) -> Numbers:
    """Return the position of an effector's tip in the frame of the tip's link, m."""
    if effector.tip is None:
        return (0.0, 0.0, 0.0)
    return tip_offset(model, effector.joints[-1], effector.tip)


def between_pads(
    model: UrdfModel, effectors: Mapping[str, SemanticGroup], hands: Mapping[str, ProposedHand]
) -> Iterator[tuple[str, Numbers]]:
    """Aim pads at the tips of the arms that carry them; yield these arms, with offsets."""
    for hand in hands.values():
        way = [joint.name for joint in model.way(hand.pads[0].link)]
        for name, each in effectors.items():
            if each.tip is not None and each.joints[-1].name in way:
                offset = (0.0, 0.0, 0.0) if is_acting(each.tip) else hand.grip(each.tip)
                # Behind the fingers it is moved to their far end, as for cameras.
                corners = hand_corners(model, each.joints[-1].child, each.tip)
                hand.aim(each.tip, (working_frame(corners, offset) or offset)[:3])
                yield name, offset


def proposed_postures(model: UrdfModel, effector: SemanticGroup, offset: Numbers) -> Postures:
    """Return a start posture in which the tip can move in all directions, and another, if any.

    The other posture is the model's own if the limb is clear of itself and the ground there, and
    its efforts hold it. Else it is the start posture, turned aside at the first joint.
    """
    plain = tuple(at_first(joint) for joint in effector.joints)
    if effector.tip is None:
        return {"ready": plain}
    row = ReadyPosture(model, effector.joints, effector.tip, offset)
    ready = row.find()
    # For example with fewer joints than a tip needs to move in three directions.
    if ready == plain:
        return {"ready": ready}
    if row.is_clear(plain) and row.can_hold(plain):
        return {"ready": ready, "middle" if any(plain) else "zero": plain}
    # A turn at the first joint moves the limb as a whole, so that it stays clear of itself.
    aside = (ready[0] + _ASIDE, *ready[1:])
    first = effector.joints[0]
    fits = not first.slides and (first.endless or aside[0] < first.upper)
    fits = fits and row.can_hold(aside)
    return {"ready": ready, "aside": aside} if fits else {"ready": ready}


def values_lines(
    model: UrdfModel, effector: SemanticGroup, offset: Numbers, hand: ProposedHand | None
) -> list[str]:
    """Return the values of an arm or a hand for programs over roles, as lines."""
    if hand is not None:
        span, unit = hand.span, "m" if effector.joints[0].slides else "rad"
        shut, opened = hand.postures["closed"][0], hand.postures["open"][0]
        way = abs(opened - shut)
        slack, probe = f"{_SLACK * way:.2g} {unit}", f"{way / _PROBING:.2g} {unit}/s"
        return [
            "  # Width between the open pads, forces of each at a touch, at a grasp and while it",
            "  # holds, position with nothing between, tolerance of an open hand, distance of",
            "  # tip and held object, and speed of fingers that feel for contact.",
            f"  values: {{span: {100 * span:.3g} cm, touch: 2 N, grip: 8 N, hold: 8 N, "
            f"probe: {probe}, shut: {shut:.4g} {unit}, slack: {slack}, nearest: 0 m, "
            "farthest: 0 m}",
        ]
    if effector.tip is None or len(effector.joints) < PLACING:
        return []
    length = ReadyPosture(model, effector.joints, effector.tip, offset).length
    beyond = _beyond_tip(model, effector, offset)
    near, far = (f"{100 * (part * length + beyond):.2g} cm" for part in _BEFORE)
    return [
        "  # Distance of the tip from the surface of the object to reach, and its bounds.",
        f"  values: {{gap: {near}, nearest: {near}, farthest: {far}}}",
    ]


def _beyond_tip(model: UrdfModel, arm: SemanticGroup, offset: Numbers) -> float:
    """Return the extent of a hand beyond the tip that a program brings to objects, m.

    Programs stand off along the tip's z axis. The hand may extend along it, beyond a flange, or
    along another axis, with half of its width along z.
    """
    assert arm.tip is not None
    corners = hand_corners(model, arm.joints[-1].child, arm.tip)
    return max(0.0, float(corners[1:, 2].max(initial=0.0)) - offset[2])


def effector_lines(
    name: str, effector: SemanticGroup, offset: Numbers, postures: Postures, values: Sequence[str]
) -> str:
    """Return an effector of a document; ``values`` are lines of their own."""
    lengths = ", ".join(f"{each:g} m" for each in offset)
    tip = f"  tip: {{link: {scalar(effector.tip or '')}, offset: [{lengths}]}}"
    lines = [
        f"{name}:",
        *(f"  # {legible(joint.name)}: {_limits(joint)}" for joint in effector.joints),
        f"  joints: [{', '.join(scalar(joint.name) for joint in effector.joints)}]",
        *([] if effector.tip is None else [_TIP, tip]),
        *_postures(effector.joints, postures),
        *values,
        f"  start: {next(iter(postures))}",
    ]
    return "\n".join(f"  {line}" for line in lines)


def _postures(joints: Sequence[UrdfJoint], postures: Mapping[str, Sequence[float]]) -> list[str]:
    texts = [
        f"{scalar(name)}: [{', '.join(map(coordinate, joints, positions))}]"
        for name, positions in postures.items()
    ]
    if len(texts) == 1:
        return [f"  postures: {{{texts[0]}}}"]
    return ["  postures:", *(f"    {text}" for text in texts)]


def coordinate(joint: UrdfJoint, position: float) -> str:
    """Return a position with its unit; whole degrees are written in degrees."""
    if joint.slides:
        return f"{position:.7g} m" if position else "0"
    degrees = math.degrees(position)
    # Whole degrees are easier to read than 0.7853982 rad.
    whole = position and math.isclose(degrees, round(degrees), abs_tol=1e-6)
    return f"{round(degrees)} deg" if whole else f"{position:.7g}"


def _limits(joint: UrdfJoint) -> str:
    if joint.endless:
        return "without end"
    scale, form, unit = (1.0, "g", "m") if joint.slides else (math.degrees(1.0), ".0f", "deg")
    # A joint may be limited on one side only; a URDF may also state infinite limits.
    if math.isfinite(joint.upper - joint.lower):
        return f"{scale * joint.lower:{form}} to {scale * joint.upper:{form}} {unit}"
    below, above = math.isfinite(joint.lower), math.isfinite(joint.upper)
    if not (below or above):
        return "without end"
    word, limit = ("from", joint.lower) if below else ("to", joint.upper)
    return f"{word} {scale * limit:{form}} {unit}, without end"

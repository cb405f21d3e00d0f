"""Orientation of a hand at its object, against the orientations that its controllers declare."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.extend.diagnosis import Floats, quaternion_about, turned
from cbdsl_why.history import ControllerCourse, FailureCause, History

# Angle between a hand and its orientation at the object above which it is turned, rad.
_TURNED = math.radians(15)
# Angle of a hand to vertical and level above which it is oblique, angle to its way, rad, and the
# length of that way, m.
_OBLIQUE, _ACROSS, _WAY = math.radians(25), math.radians(50), 0.05
# Angle between palms of two arms and the line between them that no press causes, rad.
_AVERTED = math.radians(75)
# Time within which controllers of one action ended, s.
_TOGETHER = 0.5
# Force of fingertips that stand on something, N.
_PRESSED = 0.5
# Share of an initial error that remains if nothing turned.
_UNTURNED = 0.8


def orientations(history: History, hand: str) -> list[ControllerCourse]:
    """Return the courses that turn the arm of a hand; those of a relative ``here`` only keep it."""
    return [each for each in _of_arm(history, hand) if each.reference != "here"]


def keeps_any(history: History, hand: str) -> bool:
    """Return whether controllers keep any orientation of a hand, which no controller demands."""
    courses = _of_arm(history, hand)
    return bool(courses) and all(each.reference == "here" for each in courses)


def _of_arm(history: History, hand: str) -> list[ControllerCourse]:
    """Return the courses that turn the arm of a hand, or keep its orientation."""
    signals, joints = history.summary["signals"], history.arm_of(hand)
    return [
        each
        for each in history.courses
        if signals.get(each.feedback, {}).get("type") == "orientation"
        and (not joints or each.effector.partition(".")[0] in joints)
    ]


def oriented(history: History, hand: str, ticks: tuple[int, int], clause: str) -> FailureCause:
    """Return the cause of a hand that had an orientation, or none, in which its object stopped it.

    Args:
        history: Recorded episode.
        hand: Name of the hand.
        ticks: First and last tick in which the object stopped it.
        clause: Clause that states this.
    """
    first, last = ticks
    acts = [each for each in orientations(history, hand) if each.acts[first : last + 1].any()]
    if not acts:
        return FailureCause("no_rotation", first, f"{clause}: no controller turned the hand")
    force = float(np.median(history.forces(hand)[first : last + 1]))
    if force > _PRESSED:
        clause = f"{clause}: its fingers pressed on something beside it with {force:.1f} N"
        return FailureCause("wrong_object", first, clause)
    return FailureCause("rotation", first, f"{clause}, turned as {acts[0].name} demands")


def turned_hand(history: History, hand: str, tick: int, closed: str) -> FailureCause | None:
    """Return the orientation that a hand did not have at a tick, if any."""
    courses = orientations(history, hand)
    acted = _latest(history, courses, tick)
    across = _across(history, hand, tick)
    facing = _facing(history, hand, tick, closed, acted)
    if facing is not None:
        return facing
    if not courses and (_is_oblique(history, hand, tick) or across > _ACROSS):
        return FailureCause("no_rotation", tick, f"{closed}: no controller turned the hand")
    if courses and not acted:
        if _agrees(history, courses, tick):
            return None
        clause = f"{closed}: {courses[0].name} had not turned the hand before"
        return FailureCause("no_rotation", tick, clause)
    for course in acted:
        errors = course.errors[: tick + 1][~np.isnan(course.errors[: tick + 1])]
        if len(errors) and errors[-1] > _TURNED:
            kind = "no_rotation" if errors[-1] > _UNTURNED * errors[0] else "rotation"
            left = course.measure(float(errors[-1]))
            clause = f"{closed}: {course.name} was still {left} from its orientation"
            return FailureCause(kind, tick, clause, {"error": float(errors[-1])})
    if acted and across > _ACROSS:
        clause = f"{closed}, and pointed {math.degrees(across):.0f} deg away from its way to it"
        return FailureCause("rotation", tick, clause, {"angle": across})
    return at_odds(history, hand, tick, closed)


def _facing(
    history: History, hand: str, tick: int, clause: str, acted: list[ControllerCourse]
) -> FailureCause | None:
    """Return the orientation of hands of two arms that do not face each other, if they do not.

    They press along the normals of their palms on an object between them.
    """
    pair = history.pair(hand)
    if not pair:
        return None
    way = np.subtract(*(history.palm_place(arm)[tick] for arm in reversed(pair)))
    way = way / (np.linalg.norm(way) or 1.0)
    links = [history.summary["robot"]["tips"][arm]["link"] for arm in pair]
    normals = [history.turns(link)[tick, :, 2] for link in links]
    angles = [_angle(float(normals[0] @ way)), _angle(float(-normals[1] @ way))]
    worst = int(np.argmax(angles))
    if angles[worst] < _AVERTED:
        return None
    turned = [each for each in acted if each.hand == pair[worst]]
    clause = f"{clause}: {pair[worst]} pointed {math.degrees(angles[worst]):.0f} deg away from"
    kind = "rotation" if turned else "no_rotation"
    return FailureCause(kind, tick, f"{clause} {pair[1 - worst]}", {"angle": angles[worst]})


def _is_oblique(history: History, hand: str, tick: int) -> bool:
    """Return whether a hand points neither along gravity nor level, as without control."""
    turns = history.palm(hand)
    rise = abs(float(turns[tick, 2, 2])) if len(turns) else 1.0
    return _OBLIQUE < _angle(rise) < math.pi / 2 - _OBLIQUE


def _across(history: History, hand: str, tick: int) -> float:
    """Return the angle between a hand and the last part of its way to an object, rad.

    Fingers first, it has the object between them when it arrives.
    """
    turns, centres = history.palm(hand), history.centres(hand)
    away = np.flatnonzero(np.linalg.norm(centres[:tick] - centres[tick], axis=1) > _WAY)
    if not len(turns) or not len(away) or not history.near[tick]:
        return 0.0
    way = centres[tick] - centres[away[-1]]
    return _angle(float(turns[tick, :, 2] @ way / np.linalg.norm(way)))


def _latest(history: History, courses: list[ControllerCourse], tick: int) -> list[ControllerCourse]:
    """Return the courses that acted last before a tick."""
    acted = [(np.flatnonzero(each.acts[: tick + 1]), each) for each in courses]
    last = max((int(ticks[-1]) for ticks, _ in acted if len(ticks)), default=0)
    since = last - history.ticks(_TOGETHER)
    return [each for ticks, each in acted if len(ticks) and ticks[-1] >= since]


def _agrees(history: History, courses: list[ControllerCourse], tick: int) -> bool:
    """Return whether a hand had the tilt of a constant orientation, though none turned it."""
    for course in courses:
        tilt, turn = _tilt(course.reference), history.recorded.signals[course.feedback][tick]
        if tilt is not None and _angle(tilt @ turn[:, 2]) < _TURNED:
            return True
    return False


def at_odds(history: History, hand: str, tick: int, clause: str) -> FailureCause | None:
    """Return the rotation of a hand against another orientation that it should have, if any.

    These are the object that a reference is relative to, and constants of other controllers of the
    same programs, whose tilts are compared. One of them that agrees confirms an orientation.
    """
    courses = orientations(history, hand)
    values = history.recorded.signals
    facing = _facing(history, hand, tick, clause, _latest(history, courses, tick))
    if facing is not None:
        return facing
    for course in _latest(history, courses, tick):
        name, angle = course.base, 0.0
        # The error of a course shows a turn against its own reference.
        if history.channels(course.base) and course.reference != course.base:
            turn = values[course.feedback][tick].T @ values[course.base][tick]
            angle = _angle((float(np.trace(turn)) - 1.0) / 2.0)
        tilt = _tilt(course.reference)
        others = [each for each in courses if each is not course and _is_related(each, course)]
        tilts = [(each.name, _tilt(each.reference)) for each in others]
        angles = [
            (_angle(float(tilt @ other)), label)
            for label, other in tilts
            if tilt is not None and other is not None
        ]
        if angles:
            angle, name = min(angles)
        if angle > _TURNED:
            clause = f"{clause}, turned by {math.degrees(angle):.0f} deg against {name}"
            return FailureCause("rotation", tick, clause, {"angle": angle})
    return None


def _is_related(one: ControllerCourse, other: ControllerCourse) -> bool:
    """Return whether two controllers turn one hand in one program, or in a used one."""
    programs = (one.program, other.program)
    is_within = programs[0].startswith(programs[1]) or programs[1].startswith(programs[0])
    # A hand may turn an object otherwise than it takes it.
    is_alike = bool(one.requires) == bool(other.requires)
    return one.feedback == other.feedback and is_within and is_alike


def _angle(cosine: float) -> float:
    return 0.0 if math.isnan(cosine) else math.acos(min(1.0, max(-1.0, float(cosine))))


def _tilt(reference: str) -> Floats | None:
    """Return the z axis of a constant orientation, shape (3,); ``None`` for another reference."""
    try:
        vector = np.array([float(each) for each in reference.split(",")])
    except ValueError:
        return None
    angle = float(np.linalg.norm(vector))
    return turned(quaternion_about(vector / (angle or 1.0), angle), np.array([0.0, 0.0, 1.0]))

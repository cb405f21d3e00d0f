"""Orientations that a hand had at its object, and those that it should have had."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.extend.diagnosis import Floats, quaternion_about, turned
from cbdsl_why.history import ControllerCourse, FailureCause, History

# Angle between a hand and its orientation at the object above which it is turned, rad.
_TURNED = math.radians(15)
# Force of fingertips that stand on something, N.
_PRESSED = 0.5
# Share of an initial error that remains if nothing turned.
_UNTURNED = 0.8


def orientations(history: History, hand: str) -> list[ControllerCourse]:
    """Return the courses that turn the arm of a hand; those of a relative ``here`` only keep it."""
    signals, joints = history.summary["signals"], history.arm_of(hand)
    return [
        each
        for each in history.courses
        if signals.get(each.feedback, {}).get("type") == "orientation"
        and each.reference != "here"
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
    acted = [each for each in courses if each.acts[: tick + 1].any()]
    if courses and not acted:
        clause = f"{closed}: {courses[0].name} had not turned the hand before"
        return FailureCause("no_rotation", tick, clause)
    for course in acted:
        errors = course.errors[: tick + 1][~np.isnan(course.errors[: tick + 1])]
        if len(errors) and errors[-1] > _TURNED:
            kind = "no_rotation" if errors[-1] > _UNTURNED * errors[0] else "rotation"
            left = course.measure(float(errors[-1]))
            clause = f"{closed}: {course.name} was still {left} from its orientation"
            return FailureCause(kind, tick, clause, {"error": float(errors[-1])})
    wrong = _at_odds(history, tick, acted, courses)
    if wrong is None:
        return None
    clause = f"{closed}, turned by {math.degrees(wrong[1]):.0f} deg against {wrong[0]}"
    return FailureCause("rotation", tick, clause, {"angle": wrong[1]})


def _at_odds(
    history: History, tick: int, acted: list[ControllerCourse], courses: list[ControllerCourse]
) -> tuple[str, float] | None:
    """Return the name of another orientation that a hand should have, and the angle, rad.

    These are the object that a reference is relative to, and constants of other controllers, whose
    tilts are compared.
    """
    values = history.recorded.signals
    for course in acted:
        if history.channels(course.base):
            turn = values[course.feedback][tick].T @ values[course.base][tick]
            angle = math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))
            if angle > _TURNED:
                return course.base, angle
        for other in courses:
            tilts = [_tilt(each.reference) for each in (course, other)]
            if other.feedback == course.feedback and tilts[0] is not None and tilts[1] is not None:
                angle = math.acos(min(1.0, max(-1.0, float(tilts[0] @ tilts[1]))))
                if angle > _TURNED:
                    return other.name, angle
    return None


def _tilt(reference: str) -> Floats | None:
    """Return the z axis of a constant orientation, shape (3,); ``None`` for another reference."""
    try:
        vector = np.array([float(each) for each in reference.split(",")])
    except ValueError:
        return None
    angle = float(np.linalg.norm(vector))
    return turned(quaternion_about(vector / (angle or 1.0), angle), np.array([0.0, 0.0, 1.0]))

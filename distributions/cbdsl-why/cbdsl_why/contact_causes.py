"""Causes of contact: grasps of nothing, beside or across the object, slips, and other objects."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cbdsl.extend.diagnosis import Floats, quaternion_about, turned
from cbdsl_why.history import ControllerCourse, FailureCause, History, spans

# Angle between a hand and its orientation at the object above which it is turned, rad.
_TURNED = math.radians(15)
# Share of an initial error that remains if nothing turned.
_UNTURNED = 0.8
# Distance that an object moves because of a touch, m, and the force of that touch, N.
_MOVED, _TOUCH = 0.03, 0.2
# Time after a touch in which the object moves because of it, s.
_AFTER = 1.0
# Force of a fingertip that presses on something, N.
_PRESSED = 1.0
# Number of ticks of a change of action.
_CHANGE = 3
#: Share of the mean distance of open fingers from their centre up to which an object is between.
BETWEEN = 0.7


class GraspAttempt(NamedTuple):
    """Attempt of a hand to close on an object.

    Attributes:
        course: Course of the controller that closes it.
        first: Tick in which the hand began to close.
        last: Tick in which it had closed on nothing.
    """

    course: ControllerCourse
    first: int
    last: int


def contact(history: History) -> Iterator[FailureCause]:
    """Yield the contacts that a hand missed or lost, and never had again."""
    for hand in history.hands:
        courses = [each for each in history.courses if each.effector == hand and each.grasps]
        held = np.any([history.rests(each) for each in courses], axis=0)
        last_held = max(np.flatnonzero(held), default=-1)
        for kind in (_slips, _strays, _misses):
            events = list(kind(history, courses))
            # A hand that lost an object and held it again has recovered, unless it lost it again.
            if events and events[-1].tick > last_held:
                yield events[0]._replace(times=len(events))
    yield from _moved(history)


def _slips(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which a hand that held an object felt it no more."""
    held = np.any([history.rests(each) for each in courses], axis=0)
    in_contact = np.any([each.defined for each in courses], axis=0)
    # At a change of action no controller of the hand is active for a tick or two.
    for first, last in spans(~in_contact):
        is_short = first > 0 and last < min(first + _CHANGE, history.last)
        in_contact[first : last + 1] |= is_short
    for first, last in spans(in_contact):
        ends = last + 1
        if ends > history.last or not held[first:ends].any():
            continue
        losers = [each for each in courses if history.lacks(each)[last : ends + 1].any()]
        if not losers or _opens(history, courses[0].effector, ends):
            continue
        # Fingers that only lean on an object, to feel or to free it, may leave it before they hold.
        leaned = all(each.strength < _PRESSED for each in losers)
        if leaned and held[ends:].any():
            continue
        force = float(history.forces(courses[0].effector)[max(first, last - 5) : ends].max())
        clause = (
            f"the object slipped from {courses[0].effector}: {losers[0].name} felt {force:.1f} N"
        )
        yield FailureCause("slip", ends, f"{clause} and then nothing", {"force": force})


def _opens(history: History, hand: str, tick: int) -> bool:
    """Return whether a member opens or shapes a hand at a tick."""
    before = slice(max(0, tick - _CHANGE), tick)
    return any(
        each.member and each.effector == hand and not each.grasps and each.acts[before].any()
        for each in history.courses
    )


def _strays(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which fingertips touched something else than the sought object."""
    for course in courses:
        for first, last in spans(course.flag("astray")):
            pressed = history.forces(course.effector)[first : last + 1] > _PRESSED
            if not pressed.any():
                continue
            first += int(pressed.argmax())
            clause = f"{course.name} felt something else than the object it sought"
            yield FailureCause("wrong_object", first, clause)


def _misses(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the attempts of a hand that closed on nothing, by time, with their reason."""
    own = [each for each in attempts(history) if each.course in courses]
    for attempt in sorted(own, key=lambda each: each.last):
        yield _miss(history, attempt)


def attempts(history: History) -> list[GraspAttempt]:
    """Return the attempts of all hands that closed on nothing."""
    grasps = [each for each in history.courses if each.grasps]
    return [attempt for course in grasps for attempt in _attempts(history, course)]


def _attempts(history: History, course: ControllerCourse) -> Iterator[GraspAttempt]:
    """Yield the attempts of a member: its search was exhausted, or an action ended without it."""
    if not course.member:
        return
    on_way = sum((each.letters != "X" for each in history.approaches), np.zeros(len(history.time)))
    ended = {*np.flatnonzero(history.lacks(course) & (course.letters != "-")).tolist()}
    for first, last in spans(course.letters != "X"):
        ticks = np.arange(first, last + 1)
        if course.defined[ticks].any():
            continue
        tried = ticks[course.flag("seeking")[ticks]]
        over = [*ticks[course.flag("exhausted")[ticks]]]
        # A hand that is still on its way to an object has not tried to close.
        if len(tried) or (on_way[ticks] == 0).all():
            over += ended & {last, last + 1, last + 2}
        if over:
            yield GraspAttempt(course, int(tried[0]) if len(tried) else first, int(min(over)))


def _miss(history: History, attempt: GraspAttempt) -> FailureCause:
    """Return why a hand closed on nothing."""
    course, first, last = attempt
    closed = f"{course.name} closed on nothing"
    place = approached(history, first)
    if place is None:
        if history.approaches:
            clause = "before any controller had brought the hand to an object"
            return FailureCause("wrong_order", first, f"{closed}, {clause}")
        return FailureCause("no_grasp", last, closed)
    signal, position = place
    radius = BETWEEN * history.spread(course.effector, first)
    if radius:
        beside = history.beside(course.effector, first, position)
        if beside > radius:
            clause = f"{closed}, {100 * beside:.1f} cm beside {signal}: its fingers hold within"
            numbers = {"beside": beside, "radius": radius}
            return FailureCause("translation", first, f"{clause} {100 * radius:.1f} cm", numbers)
    return _turned(history, first, closed) or FailureCause(
        "no_grasp", last, f"{closed} at {signal}"
    )


def approached(history: History, tick: int) -> tuple[str, np.ndarray] | None:
    """Return the object that a controller had approached by a tick, and its known position."""
    latest, place = -1, None
    for course in history.approaches:
        values = history.places[course.base]
        acted = np.flatnonzero(course.acts[: tick + 1])
        if not len(acted) or acted[-1] <= latest:
            continue
        known = np.flatnonzero(~np.isnan(values[: tick + 1, 0]))
        if len(known):
            latest, place = int(acted[-1]), (course.base, values[known[-1]])
    return place


def _turned(history: History, tick: int, closed: str) -> FailureCause | None:
    """Return the orientation that a hand did not have at a tick, if any."""
    signals = history.summary["signals"]
    courses = [
        each
        for each in history.courses
        if signals.get(each.feedback, {}).get("type") == "orientation"
    ]
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


def _moved(history: History) -> Iterator[FailureCause]:
    """Yield the objects that a touch moved before a hand held them, if no hand ever did."""
    for hand in history.hands:
        courses = [each for each in history.courses if each.effector == hand and each.grasps]
        if np.any([history.rests(each) for each in courses]):
            continue
        touched = np.flatnonzero(history.forces(hand) > _TOUCH)
        place = approached(history, history.last)
        if not len(touched) or place is None:
            continue
        signal = place[0]
        values = history.places[signal]
        known = np.flatnonzero(~np.isnan(values[: touched[0] + 1, 0]))
        if not len(known):
            continue
        distances = np.linalg.norm((values - values[known[-1]])[:, :2], axis=1)
        beyond = np.flatnonzero(np.nan_to_num(distances[touched[0] :]) > _MOVED)
        # An object that moves later than a touch moves for another reason.
        moved = int(touched[0] + beyond[0]) if len(beyond) else history.last
        touched = touched[touched <= moved]
        if len(beyond) and touched[-1] > moved - history.ticks(_AFTER):
            far = float(np.nanmax(distances[touched[0] :]))
            clause = f"{hand} moved {signal} by {100 * far:.1f} cm before it held it"
            breaks = np.flatnonzero(np.diff(touched) > history.ticks(_AFTER))
            tick = int(touched[breaks[-1] + 1 if len(breaks) else 0])
            yield _turned(history, tick, clause) or FailureCause(
                "moved_by_touch", tick, clause, {"distance": far}
            )

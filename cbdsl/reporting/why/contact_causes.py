"""Causes of contact: grasps of nothing, beside or across the object, slips, and other objects."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cbdsl.reporting.why.history import ControllerCourse, FailureCause, History, spans

# Angle between a hand and its orientation at the object above which it is turned, rad.
_TURNED = math.radians(15)
# Share of an initial error that remains if nothing turned.
_UNTURNED = 0.8
# Distance that an object moves because of a touch, m, and the force of that touch, N.
_MOVED, _TOUCH = 0.03, 0.2
# Distance of an object beyond the open fingers at which they cannot close on it, m.
_BESIDE = 0.03


class GraspAttempt(NamedTuple):
    """GraspAttempt of a hand to close on an object.

    Attributes:
        course: ControllerCourse of the controller that closes it.
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
        held = np.any([each.letters == "1" for each in courses], axis=0)
        last_held = max(np.flatnonzero(held), default=-1)
        for kind in (_slips, _strays, _misses):
            events = list(kind(history, courses))
            # A hand that lost an object and held it again has recovered, unless it lost it again.
            if events and events[-1].tick > last_held:
                yield events[0]._replace(times=len(events))
    yield from _moved(history)


def _slips(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which a hand that held an object felt it no more."""
    held = np.any([each.letters == "1" for each in courses], axis=0)
    in_contact = np.any([np.isin(each.letters, ("0", "1")) for each in courses], axis=0)
    for first, last in spans(in_contact):
        ends = last + 1
        if ends > history.last or not held[first:ends].any():
            continue
        losers = [each for each in courses if each.letters[ends] == "-"]
        if not losers or _opens(history, courses[0].effector, ends):
            continue
        force = float(history.forces(courses[0].effector)[max(first, last - 5) : ends].max())
        clause = (
            f"the object slipped from {courses[0].effector}: {losers[0].name} felt {force:.1f} N"
        )
        yield FailureCause("slip", ends, f"{clause} and then nothing", {"force": force})


def _opens(history: History, hand: str, tick: int) -> bool:
    """Return whether a member opens or shapes a hand at a tick."""
    around = slice(max(0, tick - 3), tick + 3)
    return any(
        each.member and each.effector == hand and not each.grasps and each.acts[around].any()
        for each in history.courses
    )


def _strays(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which fingertips touched something else than the sought object."""
    for course in courses:
        for first, _ in spans(course.flag("astray")):
            clause = f"{course.name} felt something else than the object it sought"
            yield FailureCause("wrong_object", first, clause)


def _misses(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the attempts of a hand that closed on nothing, by time, with their reason."""
    attempts = [each for course in courses for each in _attempts(course)]
    for attempt in sorted(attempts, key=lambda each: each.last):
        yield _miss(history, attempt)


def _attempts(course: ControllerCourse) -> Iterator[GraspAttempt]:
    seeking, closed = course.flag("seeking"), course.flag("exhausted")
    for first, last in spans(course.letters != "X"):
        ticks = np.arange(first, last + 1)
        if not course.member or np.isin(course.letters[ticks], ("0", "1")).any():
            continue
        tried = ticks[seeking[ticks]]
        ended = ticks[closed[ticks]]
        if len(ended):
            yield GraspAttempt(course, int(tried[0]) if len(tried) else first, int(ended[0]))


def _miss(history: History, attempt: GraspAttempt) -> FailureCause:
    """Return why a hand closed on nothing."""
    course, first, last = attempt
    closed = f"{course.name} closed on nothing"
    place = _approached(history, first)
    if place is None:
        if any(history.places.get(each.base) is not None for each in history.courses):
            clause = "before any controller had brought the hand to an object"
            return FailureCause("wrong_order", first, f"{closed}, {clause}")
        return FailureCause("no_grasp", last, closed)
    signal, position = place
    fingers = history.fingers(course.effector, first)
    if len(fingers):
        centre = fingers.mean(axis=0)
        radius = float(np.linalg.norm(fingers - centre, axis=1).max())
        beside = float(np.linalg.norm((position - centre)[:2]))
        if beside > radius + _BESIDE:
            clause = f"{closed}, {100 * beside:.1f} cm beside {signal}: its fingers reach"
            numbers = {"beside": beside, "radius": radius}
            return FailureCause("translation", first, f"{clause} {100 * radius:.1f} cm", numbers)
    return _turned(history, attempt, closed) or FailureCause(
        "no_grasp", last, f"{closed} at {signal}"
    )


def _approached(history: History, tick: int) -> tuple[str, np.ndarray] | None:
    """Return the object that a controller had approached by a tick, and its known position."""
    latest, place = -1, None
    for course in history.courses:
        values = history.places.get(course.base)
        acted = np.flatnonzero(course.acts[: tick + 1])
        if values is None or course.unit != "m" or not len(acted) or acted[-1] <= latest:
            continue
        known = np.flatnonzero(~np.isnan(values[: tick + 1, 0]))
        if len(known):
            latest, place = int(acted[-1]), (course.base, values[known[-1]])
    return place


def _turned(history: History, attempt: GraspAttempt, closed: str) -> FailureCause | None:
    """Return the orientation that a hand did not have when it closed, if any."""
    tick = attempt.first
    courses = [
        each
        for each in history.courses
        if history.summary["signals"].get(each.feedback, {}).get("type") == "orientation"
    ]
    for course in courses:
        acted = np.flatnonzero(course.acts[: tick + 1] & ~np.isnan(course.errors[: tick + 1]))
        if not len(acted):
            continue
        initial, left = float(course.errors[acted[0]]), float(course.errors[acted[-1]])
        if left > _TURNED:
            kind = "no_rotation" if left > _UNTURNED * initial else "rotation"
            clause = (
                f"{closed}: {course.name} was still {course.measure(left)} from its orientation"
            )
            return FailureCause(kind, tick, clause, {"error": left, "initial": initial})
    return _against_sight(history, attempt, courses, closed) or _idle(courses, attempt, closed)


def _idle(
    courses: list[ControllerCourse], attempt: GraspAttempt, closed: str
) -> FailureCause | None:
    """Return the controllers of orientation that did not act before the hand closed, if all."""
    if courses and not any(each.acts[: attempt.first + 1].any() for each in courses):
        clause = f"{closed}: {courses[0].name} had not turned the hand before"
        return FailureCause("no_rotation", attempt.first, clause)
    return None


def _against_sight(
    history: History, attempt: GraspAttempt, courses: list[ControllerCourse], closed: str
) -> FailureCause | None:
    """Return the turn of a hand against the orientation that an object shows, if any."""
    signals = history.recorded.signals
    for signal, facts in history.summary["signals"].items():
        if facts.get("type") != "orientation" or not history.channels(signal):
            continue
        for course in courses:
            if course.base != signal:
                continue
            turn = signals[course.feedback][attempt.first].T @ signals[signal][attempt.first]
            angle = math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))
            if angle > _TURNED:
                clause = f"{closed}, turned by {math.degrees(angle):.0f} deg against {signal}"
                return FailureCause("rotation", attempt.first, clause, {"angle": angle})
    return None


def _moved(history: History) -> Iterator[FailureCause]:
    """Yield the objects that a touch moved before a hand held them, if no hand ever did."""
    for hand in history.hands:
        courses = [each for each in history.courses if each.effector == hand and each.grasps]
        if np.any([each.letters == "1" for each in courses]):
            continue
        touched = np.flatnonzero(history.forces(hand) > _TOUCH)
        approached = _approached(history, history.last)
        if not len(touched) or approached is None:
            continue
        signal = approached[0]
        values = history.places[signal]
        known = np.flatnonzero(~np.isnan(values[: touched[0] + 1, 0]))
        if not len(known):
            continue
        distances = np.linalg.norm((values - values[known[-1]])[:, :2], axis=1)
        beyond = np.flatnonzero(np.nan_to_num(distances[touched[0] :]) > _MOVED)
        if len(beyond):
            far = float(np.nanmax(distances[touched[0] :]))
            clause = f"{hand} moved {signal} by {100 * far:.1f} cm before it held it"
            yield FailureCause("moved_by_touch", int(touched[0]), clause, {"distance": far})

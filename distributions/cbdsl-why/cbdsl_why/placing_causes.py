"""Causes of placing: objects that a hand let go beside their goals, or tilted."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cbdsl_why.history import END, SHOWN, ControllerCourse, FailureCause, History, spans

# Angle by which an object is tilted between its grasp and its release, rad.
_TILTED = math.radians(15)
# Distance of an object from its goal, across gravity, beyond which it is beside it, m.
_BESIDE = 0.06
# Time for which a hand holds an object that it places, s, and distance that it moves it, m.
_HOLDS, _MOVES = 0.5, 0.04


def placings(history: History) -> Iterator[FailureCause]:
    """Yield the last release after which an object was beside its goal to the end."""
    holds = [
        (hand, first, last)
        for hand in history.hands
        for first, last in spans(history.holds(hand))
        if last - first > history.ticks(_HOLDS) and last < history.last
    ]
    for hand, first, last in sorted(holds, key=lambda each: each[2]):
        centres = history.centres(hand)
        if np.linalg.norm(centres[last] - centres[first]) < _MOVES:
            continue
        cause = _checked(history, (hand, first, last)) or _seen(history, (hand, first, last))
        if cause is not None:
            yield cause
            return


def _checked(history: History, hold: tuple[str, int, int]) -> FailureCause | None:
    """Return the misplacing that a controller measured after a release, if it never arrived.

    Such a controller compares two objects, and moves no arm.
    """
    hand, _, last = hold
    for course in history.courses:
        is_question = len(history.channels(course.feedback)) > 1 and course.unit == "m"
        if not is_question or not course.member or course.hand in history.arm_of(hand):
            continue
        measured = np.flatnonzero(course.defined[last + 1 :]) + last + 1
        if not len(measured) or course.rests_after(last) or course.letters[measured[-1]] == "1":
            continue
        error = float(course.errors[measured[-1]])
        clause = f"{course.name} was still {course.measure(error)} from its target"
        return _placed(history, hold, clause, {"error": error})
    return None


def _seen(history: History, hold: tuple[str, int, int]) -> FailureCause | None:
    """Return the misplacing of an object that was seen beside its goal at the end, if it was."""
    hand, _, last = hold
    for course in _carriers(history, hold):
        objects = _of(history, course)
        if objects is None:
            continue
        held, goal = (history.places[each] for each in objects)
        shown = history.sees(objects[0], SHOWN) & ~np.isnan(held[:, 0])
        ticks = np.flatnonzero(shown & ~np.isnan(goal[:, 0]) & ~history.holds(hand))
        ticks = ticks[ticks > last]
        if not len(ticks):
            continue
        beside = float(np.linalg.norm((held - goal)[ticks[-1], :2]))
        if beside > _BESIDE:
            clause = f"{objects[0]} was {100 * beside:.1f} cm beside {objects[1]}"
            cause = _placed(history, hold, clause, {"beside": beside})
            return cause._replace(rank=END)
    return None


def _carriers(history: History, hold: tuple[str, int, int]) -> list[ControllerCourse]:
    """Return the courses that moved a held object or its hand to another object."""
    hand, first, last = hold
    arms = history.arm_of(hand)
    return [
        each
        for each in history.courses
        if each.unit == "m" and each.hand in arms and history.channels(each.base)
        and each.acts[first : last + 1].any() and not each.is_bound
    ]  # fmt: skip


def _of(history: History, course: ControllerCourse) -> tuple[str, str] | None:
    """Return the signals of the held object and of the goal of a carrying course, if two."""
    grasped = [*history.channels(course.feedback), *history.channels(course.base)]
    channels = list(dict.fromkeys(grasped))
    signals = {history.channels(name)[0]: name for name in history.places}
    if len(channels) != 2 or not all(each in signals for each in channels):
        return None
    return signals[channels[0]], signals[channels[1]]


def _placed(
    history: History, hold: tuple[str, int, int], clause: str, numbers: dict[str, float]
) -> FailureCause:
    """Return the kind of a misplacing: a rotation if the hand had tilted the object."""
    hand, first, last = hold
    turns = history.palm(hand)
    clause = f"{hand} let go, and {clause}"
    if len(turns):
        # The vertical in the frame of the hand, at the grasp and at the release.
        cosine = float(turns[first, 2] @ turns[last, 2])
        angle = math.acos(min(1.0, max(-1.0, cosine)))
        if angle > _TILTED:
            tilted = f"{clause}: it had tilted the object by {math.degrees(angle):.0f} deg"
            return FailureCause("rotation", last, tilted, {**numbers, "angle": angle})
    return FailureCause("translation", last, clause, numbers)

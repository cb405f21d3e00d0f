"""Other objects than the sought ones, which fingers touched, pressed or carried."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cbdsl_why.history import SHOWN, ControllerCourse, FailureCause, History, spans
from cbdsl_why.orientations import orientations, turned_hand

# Force of a fingertip that presses on something, and of one that moves a free object, N.
_PRESSED, _MOVES = 1.0, 2.0
# Distance of an object from the middle of the fingers at which they do not hold it, m.
_ELSEWHERE = 0.2
# Ratio of distances from an object of a finger beside it, and of one at it.
_OUTSIDE = 1.3
# Time for which it presses, s, and the displacement of an object that it does not press on, m.
_LONG, _STILL = 0.5, 0.01


def strays(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which fingertips touched something else than the sought object."""
    for course in courses:
        for first, last in spans(course.flag("astray")):
            pressed = history.forces(course.hand)[first : last + 1] > _PRESSED
            if not pressed.any():
                continue
            first += int(pressed.argmax())
            clause = f"{course.name} felt something else than the object it sought"
            turned = turned_hand(history, course.hand, first, clause)
            yield turned or FailureCause("wrong_object", first, clause)


def held_others(history: History) -> Iterator[FailureCause]:
    """Yield the grasps of hands that moved a seen object by a grasp elsewhere.

    A controller that moves an object by an arm takes it to be in the hand.
    """
    for hand in history.hands:
        held = history.holds(hand)
        arms, centres = history.arm_of(hand), history.centres(hand)
        for course in history.courses:
            if course.feedback not in history.places or course.hand not in arms:
                continue
            far = np.linalg.norm(history.places[course.feedback] - centres, axis=1) > _ELSEWHERE
            shown = history.sees(course.feedback, SHOWN)
            # It is undefined while the object does not move with the hand.
            moves = course.acts | (history.lacks(course) & history.defined[course.feedback])
            for first, last in spans(held & moves & shown & far):
                if last - first < history.ticks(_LONG):
                    continue
                clause = (
                    f"{course.name} moved {course.feedback} by {hand}, which held another object"
                )
                yield FailureCause("wrong_object", first, clause)
                break


def one_sided(
    history: History, course: ControllerCourse, ticks: tuple[int, int], signal: str
) -> FailureCause | None:
    """Return the other object on which a finger pressed beside the sought one, if any.

    Args:
        history: Recorded episode.
        course: Course that closes the hand.
        ticks: First and last tick of the closing.
        signal: Signal of the sought object.
    """
    hand = course.hand
    for first, last, force in unmoved(history, hand, ticks, signal):
        if _presses_outside(history, hand, (first + last) // 2, signal):
            clause = f"{hand} pressed on something by {force:.1f} N from one side"
            if not orientations(history, hand):
                clause = f"{clause}, and no controller turned it"
                return FailureCause("no_rotation", first, clause)
            return FailureCause("wrong_object", first, f"{clause}, and {signal} was seen to stay")
    return None


def unmoved(
    history: History, hand: str, ticks: tuple[int, int], signal: str
) -> Iterator[tuple[int, int, float]]:
    """Yield first and last tick, and force, N, of presses that did not move a seen object.

    The sum of the forces of all fingers would move a free object. If the sought object was seen to
    stay, it is fixed, or the fingers press on another one.
    """
    first, last = ticks
    forces = history.cell_forces[:, history.cells_of(hand), :2].sum(axis=1)
    net = np.linalg.norm(forces, axis=1)
    pressed = np.zeros(len(net), dtype=bool)
    pressed[first : last + 1] = net[first : last + 1] > _MOVES
    values, seen = history.places[signal], history.sees(signal, SHOWN)
    for begin, end in spans(pressed):
        moved = np.linalg.norm(values[begin : end + 1] - values[begin], axis=1)
        is_seen = seen[begin : end + 1].all()
        if is_seen and end - begin >= history.ticks(_LONG) and moved.max() < _STILL:
            yield begin, end, float(net[begin : end + 1].max())


def _presses_outside(history: History, hand: str, tick: int, signal: str) -> bool:
    """Return whether a finger presses much farther from an object than another finger is."""
    fingers = history.fingers(hand, tick)
    distances = np.linalg.norm((fingers - history.places[signal][tick])[:, :2], axis=1)
    forces = np.linalg.norm(history.cell_forces[tick, history.cells_of(hand)], axis=1)
    pressing = distances[forces[: len(distances)] > _PRESSED]
    return bool(len(pressing) and pressing.max() > _OUTSIDE * distances.min())

"""Other objects than the sought ones, which fingers touched, pressed or carried."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cbdsl_why.history import ControllerCourse, FailureCause, History, spans

# Force of a fingertip that presses on something, and of one that moves a free object, N.
_PRESSED, _MOVES = 1.0, 2.0
# Time for which it presses, s, and the displacement of an object that it does not press on, m.
_LONG, _STILL = 0.5, 0.01


def strays(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which fingertips touched something else than the sought object."""
    for course in courses:
        for first, last in spans(course.flag("astray")):
            pressed = history.forces(course.effector)[first : last + 1] > _PRESSED
            if not pressed.any():
                continue
            first += int(pressed.argmax())
            clause = f"{course.name} felt something else than the object it sought"
            yield FailureCause("wrong_object", first, clause)


def one_sided(
    history: History, course: ControllerCourse, ticks: tuple[int, int], signal: str
) -> FailureCause | None:
    """Return the other object on which a finger pressed from one side, if any.

    The sum of the forces of all fingers would move a free object. An object that was seen to stay
    is not the one that they press on.

    Args:
        history: Recorded episode.
        course: Course that closes the hand.
        ticks: First and last tick of the closing.
        signal: Signal of the sought object.
    """
    first, last = ticks
    cells = [
        n for n, c in enumerate(history.summary["load_cells"]) if c.split(".")[0] == course.effector
    ]
    net = np.linalg.norm(history.cell_forces[:, cells].sum(axis=1)[:, :2], axis=1)
    pressed = np.zeros(len(net), dtype=bool)
    pressed[first : last + 1] = net[first : last + 1] > _MOVES
    values, seen = history.places[signal], history.sees(signal, ("seen", "several"))
    for begin, end in spans(pressed):
        moved = np.linalg.norm(values[begin : end + 1] - values[begin], axis=1)
        if end - begin < history.ticks(_LONG) or not seen[begin : end + 1].all():
            continue
        if moved.max() < _STILL:
            most = net[begin : end + 1].max()
            clause = f"{course.effector} pressed on something by {most:.1f} N from one side"
            return FailureCause("wrong_object", begin, f"{clause}, and {signal} was seen to stay")
    return None

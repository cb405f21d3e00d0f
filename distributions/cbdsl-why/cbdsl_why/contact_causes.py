"""Causes of contact: grasps of nothing, beside or across the object, slips, and other objects."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cbdsl_why.history import SHOWN, ControllerCourse, FailureCause, History, spans
from cbdsl_why.motion_causes import held_back
from cbdsl_why.orientations import at_odds, keeps_any, oriented, turned_hand
from cbdsl_why.placing_causes import placings
from cbdsl_why.wrong_objects import held_others, one_sided, strays

# Distance that an object moves because of a touch, m, and the force of that touch, N.
_MOVED, _TOUCH = 0.03, 0.2
# Time after a touch in which the object moves because of it, s.
_AFTER = 1.0
# Force of a fingertip that presses on something, N.
_PRESSED = 1.0
# Time for which an object stops a hand, s.
_STOPS = 1.0
# Distance from its target from which a hand has not arrived, m.
_SHORT = 0.03
# Distance of an object from the line between two hands that they do not press on, m.
_WIDE = 0.12
# Distance by which a hand rises more than the object that it holds, m, for how long, s, and the
# motion of an object that it has moved at all, m.
_LEFT, _LATER, _STIRRED = 0.06, 0.5, 0.02
# Ratio of the distance of an object from a hand that is not at it to the spread of the fingers.
_AWAY = 1.5
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
        courses = [each for each in history.courses if each.hand == hand and each.grasps]
        held = np.any([history.rests(each) for each in courses], axis=0)
        last_held = max(np.flatnonzero(held), default=-1)
        # An object that has slipped through a hand that still presses is not held.
        yield from _slides(history, courses)
        for kind in (_slips, _unheld, strays, _misses, _stops):
            events = list(kind(history, courses))
            # A hand that lost an object and held it again has recovered, unless it lost it again.
            again = (
                kind is _slips and len(events) > 1 and events[-1].tick > last_held - last_held / 4
            )
            if events and (events[-1].tick > last_held or again):
                yield events[0]._replace(times=len(events))
    yield from held_others(history)
    yield from placings(history)
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
        if not losers or _opens(history, courses[0].hand, ends):
            continue
        # Fingers that only lean on an object, to feel or to free it, may leave it before they hold.
        leaned = all(each.strength < _PRESSED for each in losers)
        if leaned and held[ends:].any():
            continue
        begin = first + int(held[first:ends].argmax())
        clause = f"{courses[0].hand} lost the object that it had grasped"
        early = _early(history, losers[0], first, clause)
        if early is not None:
            yield early._replace(tick=ends)
            continue
        askew = at_odds(history, courses[0].hand, begin, clause)
        if askew is not None:
            yield askew._replace(tick=ends)
            continue
        force = float(history.forces(courses[0].hand)[max(first, last - 5) : ends].max())
        clause = f"the object slipped from {courses[0].hand}: {losers[0].name} felt {force:.1f} N"
        yield FailureCause("slip", ends, f"{clause} and then nothing", {"force": force})


def _early(
    history: History, course: ControllerCourse, tick: int, clause: str
) -> FailureCause | None:
    """Return the order of a hand that had closed before the last approach of its program."""
    while tick > 0 and course.acts[tick - 1]:
        tick -= 1
    place = approached(history, tick + _CHANGE, course.hand)
    attempt = GraspAttempt(course, tick + _CHANGE, tick + _CHANGE)
    return None if place is None else _left_out(history, attempt, place[0], clause)


def _slides(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the tick in which a lifted hand left an object behind that it had moved a little.

    Only the last hold counts, as an earlier one may have been made good.
    """
    hand = courses[0].hand
    heights, holds = history.lifted(hand), list(spans(history.holds(hand)))
    place = approached(history, holds[-1][0], hand) if holds else None
    if place is None:
        return
    held = slice(holds[-1][0], holds[-1][1] + 1)
    values = history.places[place[0]][held, 2]
    shown = history.sees(place[0], SHOWN)[held] & ~np.isnan(values)
    rose, moved = heights[held] - heights[held.start], np.abs(values - values[shown.argmax()])
    left = np.flatnonzero(shown & (rose - moved > _LEFT))
    if len(left) > history.ticks(_LATER) and np.nanmax(moved) > _STIRRED:
        tick = held.start + int(left[0])
        clause = f"{place[0]} slipped through {hand}, which rose by {100 * rose.max():.1f} cm"
        yield FailureCause("slip", tick, clause, {"left": float(rose[left[0]])})


def _unheld(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which a hand lost an object that it pressed, and had never held one."""
    if np.any([history.rests(each) for each in courses]):
        return
    force = history.forces(courses[0].hand)
    for course in courses if any(each.member for each in courses) else ():
        for first, last in spans(course.defined):
            if last == history.last or last - first < history.ticks(_STOPS):
                continue
            if history.lacks(course)[last : last + 1 + _CHANGE].any():
                most = force[first : last + 1].max()
                clause = f"{course.name} pressed with up to {most:.1f} N, held nothing and lost it"
                if keeps_any(history, course.hand):
                    clause = f"{clause}: no controller turned the hand"
                    yield FailureCause("no_rotation", first, clause)
                    continue
                yield (
                    turned_hand(history, course.hand, first, clause)
                    or FailureCause("no_grasp", last + 1, clause, {"force": float(most)})
                )


def _opens(history: History, hand: str, tick: int) -> bool:
    """Return whether a member opens or shapes a hand at a tick."""
    before = slice(max(0, tick - _CHANGE), tick)
    return any(
        each.member and each.hand == hand and not each.grasps and not each.requires
        and each.acts[before].any()
        for each in history.courses
    )  # fmt: skip


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
        if len(tried):
            over += [tick for tick in _stalls(history, course) if tried[0] <= tick <= last]
        if over:
            last = int(min(over))
            yield GraspAttempt(course, int(tried[0]) if len(tried) else first, last)


def _stalls(history: History, course: ControllerCourse) -> list[int]:
    """Return the ticks in which an action of a controller's program ended without a change."""
    use = course.program.rstrip(".")
    return [
        history.tick(each["time"])
        for each in history.transitions
        if each["state"] == each["next_state"] and each.get("use", "") == use
    ]


def _miss(history: History, attempt: GraspAttempt) -> FailureCause:
    """Return why a hand closed on nothing."""
    course, first, last = attempt
    closed = f"{course.name} closed on nothing"
    place = approached(history, first, course.hand)
    if place is None:
        if history.approaches:
            clause = "before any controller had brought the hand to an object"
            return FailureCause("wrong_order", first, f"{closed}, {clause}")
        return FailureCause("no_grasp", last, closed)
    signal = place[0]
    beside = _beside(history, course.hand, first, closed, place)
    if beside is not None:
        return (
            _left_out(history, attempt, signal, closed)
            or _kept_short(history, first, signal, beside)
            or beside
        )
    away = float(np.linalg.norm(place[1] - history.centres(course.hand)[first]))
    is_far = away > _AWAY * history.spread(course.hand, first)
    return (
        (_left_out(history, attempt, signal, closed) if is_far else None)
        or turned_hand(history, course.hand, first, closed)
        or one_sided(history, course, (first, last), signal)
        or FailureCause("no_grasp", last, f"{closed} at {signal}")
    )


def _beside(
    history: History, hand: str, tick: int, closed: str, place: tuple[str, np.ndarray]
) -> FailureCause | None:
    """Return the translation of a hand that was beside an object at a tick, if it was."""
    signal, position = place
    radius = BETWEEN * history.spread(hand, tick)
    if not radius:
        return None
    beside = history.beside(hand, tick, position)
    pair = history.pair(hand)
    if pair:
        beside, radius = _off_line(history, pair, tick, position), _WIDE
    clause = f"{closed}, {100 * beside:.1f} cm beside {signal}: its fingers hold within"
    numbers = {"beside": beside, "radius": radius}
    cause = FailureCause("translation", tick, f"{clause} {100 * radius:.1f} cm", numbers)
    return cause if beside > radius else None


def _off_line(history: History, pair: tuple[str, str], tick: int, position: np.ndarray) -> float:
    """Return the distance of a position from the line through the palms of two arms, m."""
    one, other = (history.palm_place(arm)[tick] for arm in pair)
    line = (other - one) / (np.linalg.norm(other - one) or 1.0)
    away = position - one
    return float(np.linalg.norm(away - (away @ line) * line))


def _kept_short(
    history: History, tick: int, signal: str, beside: FailureCause
) -> FailureCause | None:
    """Return the obstacle that kept the latest approach of an object from its target, if any."""
    acted = [
        (int(np.flatnonzero(each.acts[: tick + 1])[-1]), each)
        for each in history.approaches
        if each.base == signal and each.acts[: tick + 1].any()
    ]
    last, course = max(acted, key=lambda each: each[0])
    errors = course.errors[: last + 1][~np.isnan(course.errors[: last + 1])]
    short = beside.numbers["beside"] - beside.numbers["radius"]
    if not len(errors) or errors[-1] < max(short, _SHORT):
        return None
    return held_back(history, course, last)


def _left_out(
    history: History, attempt: GraspAttempt, signal: str, closed: str
) -> FailureCause | None:
    """Return the order of a hand that closed before the last approach of its program."""
    course, first, _ = attempt
    own = [
        each
        for each in history.approaches
        if each.base == signal and each.program == course.program
        and not each.requires and not each.is_bound
    ]  # fmt: skip
    acted = [each for each in own if each.acts[: first + 1].any()]
    left = [each for each in own if not each.acts[: first + 1].any()]
    if not acted or not left:
        return None
    return FailureCause("wrong_order", first, f"{closed} before {left[0].name} had moved the hand")


def approached(history: History, tick: int, hand: str = "") -> tuple[str, np.ndarray] | None:
    """Return the object that a controller had approached by a tick, and its known position.

    Of several that controllers approached together, it is the nearest one to a hand.
    """
    objects = list[tuple[int, str, np.ndarray]]()
    for course in history.approaches:
        values = history.places[course.base]
        acted = np.flatnonzero(course.acts[: tick + 1])
        known = np.flatnonzero(~np.isnan(values[: tick + 1, 0]))
        if len(acted) and len(known):
            objects.append((int(acted[-1]), course.base, values[known[-1]]))
    latest = max((last for last, _, _ in objects), default=0)
    objects = [each for each in objects if each[0] >= latest - _CHANGE]
    fingers = history.fingers(hand, tick) if hand and len(objects) > 1 else np.zeros((0, 3))
    if len(fingers):
        objects.sort(key=lambda each: float(np.linalg.norm(each[2] - fingers.mean(axis=0))))
    return objects[0][1:] if objects else None


def _moved(history: History) -> Iterator[FailureCause]:
    """Yield the objects that a touch moved before a hand held them, if no hand ever did."""
    grasps = [each for each in history.courses if each.grasps]
    if np.any([history.rests(each) for each in grasps]):
        return
    for hand in history.hands:
        # Fingers that are in contact all around move an object on purpose.
        closed = np.any([each.defined for each in grasps if each.hand == hand], axis=0)
        touched = np.flatnonzero((history.forces(hand) > _TOUCH) & ~closed)
        place = approached(history, history.last, hand)
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
            # A hand on its way touches an object before it is above it.
            arrives = min((e.errors[tick] for e in history.approaches if e.acts[tick]), default=0.0)
            beside = _beside(history, hand, tick, clause, (signal, values[known[-1]]))
            is_beside = beside and beside.numbers["beside"] - beside.numbers["radius"] > arrives
            yield (
                (beside if is_beside else None)
                or turned_hand(history, hand, tick, clause)
                or FailureCause("moved_by_touch", tick, clause, {"distance": far})
            )


def _stops(history: History, courses: list[ControllerCourse]) -> Iterator[FailureCause]:
    """Yield the ticks in which an object stopped a hand short of it, until an action ended.

    A hand that points along its way has the object between its fingers. Another one stands on it.
    """
    hand = courses[0].hand
    pushes = history.pushes(hand)
    for course in history.approaches if pushes.any() else ():
        short = pushes & course.acts & (course.letters == "0")
        for first, last in spans(short):
            if last - first < history.ticks(_STOPS) or course.rests_after(last):
                continue
            last -= int(np.isnan(course.errors[first : last + 1])[-1])
            signal, left = course.base, course.measure(float(course.errors[last]))
            clause = f"{signal} stopped {hand}, {left} from the target of {course.name}"
            place = (signal, history.known(signal)[first])
            yield (
                _beside(history, hand, first, clause, place)
                or turned_hand(history, hand, first, clause)
                or oriented(history, hand, (first, last), clause)
            )
            break

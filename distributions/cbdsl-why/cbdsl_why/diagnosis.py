"""Diagnosis of a recorded episode: its first cause, and the families that are ruled out.

A cause is stated if the recorded facts agree with each other until then. Where they do not, an
unknown fault of sensors, drives or the world came first, and the causes are its symptoms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from cbdsl.extend.diagnosis import MarkedCause, Recorded
from cbdsl_why.contact_causes import contact
from cbdsl_why.course_causes import course, order
from cbdsl_why.history import HALT, FailureCause, History
from cbdsl_why.motion_causes import motion
from cbdsl_why.premises import doubts
from cbdsl_why.robot_causes import robot
from cbdsl_why.sight_causes import sight

# Causes this close together have one origin, which the earlier family names, s.
_TOGETHER = 0.2


class Family(NamedTuple):
    """Family of causes.

    Attributes:
        name: Name of the family.
        find: Finder of its causes that are in force at the end.
        absent: Clause for an episode without such a cause.
    """

    name: str
    find: Callable[[History], Iterator[FailureCause]]
    absent: str


#: All families; of simultaneous causes the first one counts.
FAMILIES = (
    Family("robot", robot, "the robot followed its references, and nothing halted it"),
    Family("order", order, "no controller required a contact before its time"),
    Family("contact", contact, "no hand closed on nothing, lost an object or moved one"),
    Family("sight", sight, "every object that a member needed was seen"),
    Family("motion", motion, "no member stayed short of its target"),
    Family("course", course, "no cycle, no limit and no state without an action"),
)


class Diagnosis(NamedTuple):
    """First cause of an episode.

    Attributes:
        failed: True if the episode did not succeed.
        cause: The first cause; ``None`` if there is none, or none is known.
        others: Other causes in force at the end, by time, or symptoms of an unknown one.
        ruled_out: A clause for each family without a cause.
        doubts: Contradictions of the recording before which no cause lies; else empty.
        missing: A clause if the recording lacks facts of controllers and sight; else empty.
    """

    failed: bool
    cause: FailureCause | None
    others: tuple[FailureCause, ...]
    ruled_out: tuple[str, ...]
    missing: str
    doubts: tuple[str, ...] = ()


def diagnose(history: History) -> Diagnosis:
    """Return the first cause of an episode; the truth of a simulation is not read."""
    failed = history.recorded.failed
    missing = (
        ""
        if history.is_complete
        else ("recorded by an older cb, without the facts of contacts and sight; record it again")
    )
    if not failed:
        return Diagnosis(failed, None, (), (), missing)
    causes = [
        (cause, place) for place, family in enumerate(FAMILIES) for cause in family.find(history)
    ]
    present = {place for _, place in causes}
    ruled_out = tuple(each.absent for n, each in enumerate(FAMILIES) if n not in present)
    causes.sort(key=lambda each: (each[0].rank, each[0].tick))
    contradictions, near = doubts(history), history.ticks(_TOGETHER)
    if not causes:
        clauses = tuple(each.clause for each in contradictions)
        return Diagnosis(failed, None, (), ruled_out, missing, clauses)
    earliest = causes[0][0]
    horizon = earliest.tick + near
    together = [
        each for each in causes if each[0].rank == earliest.rank and each[0].tick <= horizon
    ]
    first = min(together, key=lambda each: each[1])[0]
    clauses = tuple(each.clause for each in contradictions if each.tick <= first.tick + near)
    if clauses and first.rank != HALT:
        symptoms = tuple(cause for cause, _ in causes)
        return Diagnosis(failed, None, symptoms, ruled_out, missing, clauses)
    others = tuple(cause for cause, _ in causes if cause is not first)
    return Diagnosis(failed, first, others, ruled_out, missing)


def causes(recorded: Recorded) -> list[MarkedCause]:
    """Return the causes of a failed episode for its page, the first one first."""
    history = History(recorded)
    diagnosis = diagnose(history)
    rows = (diagnosis.cause, *diagnosis.others) if diagnosis.cause is not None else ()
    return [MarkedCause(each.kind, float(history.time[each.tick]), each.sentence) for each in rows]

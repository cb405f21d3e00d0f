"""Causes of motion: levels that came no nearer, and their holders, limits and guards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from cbdsl.extend.diagnosis import (
    BLOCKED,
    CLEARANCE,
    CREEPING,
    LIMITS,
    OPTIMUM,
    OUT_OF_REACH,
    SINGULAR,
)
from cbdsl_why.history import ControllerCourse, FailureCause, History, Mask

# Time before the end of an action in which a level's holder counts, s.
_LOOKED_AT = 0.5
# Share of a final error up to which an earlier one is no nearer.
_SAME = 1.05
# Share of a task velocity above which a level was not held.
_SMALL_SHARE = 0.5
# Least share of the examined ticks in which a guard or a limit holds.
_MOSTLY = 0.5

_KINDS = {
    LIMITS: "limit",
    OUT_OF_REACH: "out_of_reach",
    BLOCKED: "not_followed",
    CLEARANCE: "guard",
    OPTIMUM: "stuck",
    SINGULAR: "stuck",
    CREEPING: "stuck",
}


def motion(history: History) -> Iterator[FailureCause]:
    """Yield the levels that ended an action short of their targets, and never arrived later.

    These are members, and levels towards seen objects, which matter even below a member.
    """
    ends = [history.tick(each["time"]) for each in history.transitions]
    over = [
        tick
        for tick, each in zip(ends, history.transitions, strict=True)
        if each["state"] == each["next_state"]
    ]
    for course in history.courses:
        # A level that no joint moves is a question about the world, and its answer is no cause.
        by_others = (course.holders >= 0) & (course.holders < len(history.courses))
        if course.grasps or not (course.ranks.any() or by_others.any()):
            continue
        if not (course.member or course in history.approaches):
            continue
        # A level that waits where it is has nowhere to arrive, and a bound that requires a grasp
        # asks whether the object follows.
        if course.reference == "here" or (course.requires and course.is_bound):
            continue
        short = _is_short(course)
        arrived = np.flatnonzero((course.letters == "1") & ~course.flag("stuck"))
        last_arrived = max(arrived, default=-1)
        ticks = [*(over if course.member else ends), history.last]
        ticks = [t for t in ticks if short[max(0, t - 1) : t + 1].any()]
        if course.member:
            ticks += list(np.flatnonzero(course.flag("stuck")))
        late = sorted(t for t in ticks if t > last_arrived)
        cause = held_back(history, course, late[0]) if late else None
        if cause is not None:
            yield cause


def _is_short(course: ControllerCourse) -> Mask:
    """Return the ticks in which a level is on its way, or at rest beyond its tolerance."""
    going = course.acts & ~np.isnan(course.errors)
    short: Mask = going & ((course.letters == "0") | course.flag("stuck"))
    return short


def held_back(history: History, course: ControllerCourse, end: int) -> FailureCause | None:
    """Return the cause that kept a level from its target until a tick; ``None`` if it moved."""
    acting = np.flatnonzero(_is_short(course)[: end + 1])
    end = int(acting[-1])
    begin = end
    while begin > 0 and course.acts[begin - 1] and course.letters[begin - 1] != "X":
        begin -= 1
    error = float(course.errors[end])
    farther = np.flatnonzero(course.errors[begin : end + 1] > _SAME * error)
    since = begin + (int(farther[-1]) + 1 if len(farther) else 0)
    left = f"{course.name} stayed {course.measure(error)} from its target"
    late = slice(max(begin, end - history.ticks(_LOOKED_AT)), end + 1)
    numbers = {"error": error}
    kind, reason = _reason(history, course, late, numbers)
    return FailureCause(kind, since, f"{left}{reason}", numbers) if kind else None


def _reason(
    history: History, course: ControllerCourse, late: slice, numbers: dict[str, float]
) -> tuple[str, str]:
    """Return the kind of a rest short of a target, and its words."""
    arrays = history.recorded.arrays
    far = _beyond(history, course, late.stop - 1)
    if far:
        numbers["distance"], numbers["reach"] = far
        clause = f": that is {100 * far[0]:.0f} cm from a joint that reaches {100 * far[1]:.0f} cm"
        return "out_of_reach", clause
    guards = _most(arrays.get("guard_held"), late, history.summary.get("guards", ()))
    if guards:
        return "guard", f": the motion gave way to the guard of {' and '.join(guards)}"
    name = course.name.rsplit(".", 1)[-1]
    stated = history.result.get("causes", {}).get(name, "")
    shares = course.shares[late]
    share = float(np.nanmedian(shares)) if not np.isnan(shares).all() else 1.0
    numbers["share"] = share
    holders = Counter(history.holder(int(n)) for n in course.holders[late])
    holder = holders.most_common(1)[0][0]
    # Why an object stopped a hand is a matter of contact.
    if any(history.pushes(hand)[late].mean() > _MOSTLY for hand in history.hands):
        return "", ""
    if stated and not stated.startswith("held by") and stated != CREEPING:
        kind = next((kind for key, kind in _KINDS.items() if stated.startswith(key)), "stuck")
        return kind, f": {stated}"
    limits = _most(arrays["at_limits"], late, history.summary["joints"])
    if holder == LIMITS or (limits and share < _SMALL_SHARE and holder in ("", OPTIMUM)):
        return "limit", f": {' and '.join(limits) or 'joints'} were at their limits"
    if holder in _KINDS:
        return _KINDS[holder], f" at a {holder}"
    if _yields(history, course, holder, late):
        return "", ""
    if holder and share < _SMALL_SHARE:
        taken = f"which left it {100 * max(0.0, share):.0f} % of its motion"
        # No arm reaches a target in an orientation that it cannot have there.
        kind = "rotation" if _turns(history, course, holder) else "held"
        return kind, f": held by {holder}, {taken}"
    smallest = float(np.nanmin(course.singular_values[late]))
    if share < _SMALL_SHARE and smallest < history.summary["robot"]["singular_value"]:
        return "stuck", f" close to a singularity: its smallest singular value was {smallest:.2g}"
    return "", ""


def _turns(history: History, course: ControllerCourse, holder: str) -> bool:
    """Return whether a holder turns the hand that a level brings to a seen object."""
    held_by = [each for each in history.courses if each.name == holder]
    signals = history.summary["signals"]
    return course in history.approaches and any(
        signals.get(each.feedback, {}).get("type") == "orientation" and each.reference != "here"
        for each in held_by
    )


def _yields(history: History, course: ControllerCourse, holder: str, late: slice) -> bool:
    """Return whether a level gave way to another member of its program, which was at rest."""
    return any(
        each.name == holder and each.member and each.program == course.program
        and each.effector == course.effector and (each.letters[late] == "1").any()
        for each in history.courses
    )  # fmt: skip


def _beyond(history: History, course: ControllerCourse, tick: int) -> tuple[float, float] | None:
    """Return the distance of a position beyond reach, and the reach, m; ``None`` within it."""
    effector, _, part = course.effector.partition(".")
    target = history.places.get(course.base)
    if part != "position" or target is None or np.isnan(target[tick]).any():
        return None
    joint, span = history.span(effector, tick)
    distance = float(np.linalg.norm(target[tick] - joint))
    return (distance, span) if distance > span else None


def _most(held: Mask | None, late: slice, names: list[str]) -> list[str]:
    """Return the names whose columns hold in most of the examined ticks."""
    if held is None or not len(names):
        return []
    return [names[n] for n in np.flatnonzero(held[late].mean(axis=0) >= _MOSTLY)]

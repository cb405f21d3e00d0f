"""Causes of the course of actions: their order, cycles, limits, and states without an action."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from cbdsl.extend.diagnosis import last_rounds
from cbdsl_why.history import END, ControllerCourse, FailureCause, History

# Number of equal rounds that make a cycle.
_ROUNDS = 3
# Largest number of transitions of a round.
_LONGEST = 12
# Times before the end in which a member comes nearer if time is short, s, and by which share in
# the longer one: slow members need it, and members at rest come no nearer in the shorter one.
_LATE, _LATEST, _NEARER = 2.0, 0.5, 0.02
# Relative difference of errors that are limited, and motion of an arm that goes on, m.
_SAME, _MOVES = 1e-3, 3e-3
# Motion of closing fingers, rad or m, and age of a new state, s.
_CLOSES, _RECENT = 1e-3, 2.0


def order(history: History) -> Iterator[FailureCause]:
    """Yield controllers that required a contact before any hand had tried to make it."""
    by_name = {each.name: each for each in history.courses}
    for course in history.courses:
        required = by_name.get(course.program + course.requires) if course.requires else None
        lacks = np.flatnonzero(history.lacks(course))
        if required is None or not course.member or not len(lacks) or not required.grasps:
            continue
        hand = [each for each in history.courses if each.hand == required.hand]
        tried = np.any([history.rests(each) | each.defined for each in hand if each.grasps], axis=0)
        if tried[: lacks[0]].any() or lacks[-1] < max(np.flatnonzero(tried), default=-1):
            continue
        closed = [np.flatnonzero(each.flag("exhausted")) for each in hand if each.grasps]
        if not any(len(ticks) and ticks[0] <= lacks[0] for ticks in closed):
            clause = f"{course.name} requires {required.name}, and no hand had closed before"
            yield FailureCause("wrong_order", int(lacks[0]), clause)


def course(history: History) -> Iterator[FailureCause]:
    """Yield the way in which the actions ended; these are causes only without any other."""
    own = [each for each in history.transitions if each["depth"] == 0]
    limits = history.limits
    yield from _stated(history)
    yield from _inner(history)
    yield from _cycle(history, own)
    if history.result.get("outcome") or history.result.get("halted"):
        return
    seconds, end = history.result["sim_seconds"], history.last
    if limits.get("episode_time") and seconds >= limits["episode_time"] - 0.1:
        clause = f"the {limits['episode_time']:g} s of the episode were over"
        if _came_nearer(history):
            yield FailureCause("time", end, clause, {"seconds": limits["episode_time"]}, rank=END)
    elif len(own) >= limits.get("transitions", len(own) + 1):
        clause = f"the {limits['transitions']} transitions were used up"
        yield FailureCause("time", end, clause, {"transitions": limits["transitions"]}, rank=END)
    elif own and own[-1]["state"] == own[-1]["next_state"] and _came_nearer(history):
        clause = f"{own[-1]['action']} changed nothing in {_seconds(history, own[-1]):.1f} s"
        yield FailureCause("time", end, f"{clause} in state {own[-1]['state']}", rank=END)
    elif own and own[-1]["state"] != own[-1]["next_state"]:
        clause = f"the policy has no action for state {own[-1]['next_state']}"
        yield FailureCause("no_action", history.tick(own[-1]["time"]), clause, rank=END)


def _came_nearer(history: History) -> bool:
    """Return whether more time would have helped: a member came nearer to its target at the end."""
    late, count = slice(-history.ticks(_LATE), None), history.ticks(_LATEST)
    for course in history.courses:
        errors = course.errors[late][course.acts[late]]
        nearer = len(errors) > 1 and errors[-1] < (1.0 - _NEARER) * errors[0]
        if course.member and nearer and errors[-1] < errors[-count:][0]:
            return True
        if course.member and len(errors) and _goes_on(history, course, late):
            return True
        # Fingers on their way to a contact have no error yet.
        latest = slice(-count, None)
        if course.member and course.grasps and course.flag("seeking")[latest].all():
            joints = [c for e, c in history.cell_joints.items() if e.startswith(course.hand)]
            moved = np.ptp(history.recorded.arrays["positions"][latest][:, joints], axis=0)
            if len(moved) and moved.max() > _CLOSES:
                return True
    return _is_new(history)


def _goes_on(history: History, course: ControllerCourse, late: slice) -> bool:
    """Return whether a member with a limited error moved its arm at the end."""
    errors, arm = course.errors[late], course.effector.split(".")[0]
    if arm not in history.summary["robot"].get("tips", {}) or not course.acts[late].all():
        return False
    is_beyond = float(np.ptp(errors)) < _SAME * float(errors[-1])
    moved = np.linalg.norm(np.diff(history.palm_place(arm)[late][[0, -1]], axis=0))
    return is_beyond and course.letters[-1] == "0" and bool(moved > _MOVES)


def _is_new(history: History) -> bool:
    """Return whether a program has just reached a state for the first time."""
    reached = dict[tuple[str, str, str], float]()
    for each in history.transitions:
        reached.setdefault((each["program"], each.get("use", ""), each["next_state"]), each["time"])
    return bool(reached) and max(reached.values()) >= history.time[-1] - _RECENT > 0.0


def _stated(history: History) -> Iterator[FailureCause]:
    """Yield the failure that a program states at the end, the innermost one first."""
    if history.result.get("outcome") != "failure":
        return
    latest: dict[str, Mapping[str, Any]] = {each["program"]: each for each in history.transitions}
    stated = [each for each in latest.values() if each.get("reason")]
    if stated:
        inner = max(stated, key=lambda each: each["depth"])
        clause = f"{inner['program']} states in {inner['next_state']}: {inner['reason']}"
        yield FailureCause("stated", history.tick(inner["time"]), clause, rank=END)


def _inner(history: History) -> Iterator[FailureCause]:
    """Yield the first end of a used program whose policy had no action for its state."""
    for before, after in pairwise(history.transitions):
        is_end = before["depth"] == after["depth"] + 1 and before["time"] == after["time"]
        place = history.recorded.members(after)
        name = before.get("use", "").rsplit(".", 1)[-1]
        if not is_end or name not in place or before["state"] == before["next_state"]:
            continue
        if after["next_state"][place.index(name)] == "-" and not _is_met(history, before, after):
            clause = f"{name} had no action for state {before['next_state']}"
            yield FailureCause("no_action", history.tick(before["time"]), clause, rank=END)
            return


def _is_met(history: History, end: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    """Return whether a program went on otherwise after the end of a used one.

    Args:
        history: Recorded episode.
        end: Transition with which the used program ended.
        after: Transition of the program that uses it.
    """
    later = [each for each in history.transitions if each["time"] > after["time"]]
    goes_on = any(each["depth"] == after["depth"] for each in later)
    keys = ("use", "state", "next_state", "depth")
    again = any(all(each.get(k) == end.get(k) for k in keys) for each in later)
    return goes_on and not again


def _seconds(history: History, transition: Mapping[str, Any]) -> float:
    return float(transition["ticks"] * np.median(np.diff(history.time)))


def _cycle(history: History, own: Sequence[Mapping[str, Any]]) -> Iterator[FailureCause]:
    """Yield the first repetition of the shortest cycle that lasted to the end."""
    steps = [(each["state"], each["action"], each["next_state"]) for each in own]
    length, rounds = last_rounds(steps, _LONGEST, _ROUNDS)
    if rounds:
        again = own[len(own) - length * (rounds - 1)]
        names = ", ".join(dict.fromkeys(step[1] for step in steps[-length:]))
        clause = f"{names} repeated the same states {rounds} times until the end"
        tick = max(0, history.tick(again["time"]) - again["ticks"])
        yield FailureCause("cycle", tick, clause, {"rounds": rounds, "length": length}, rank=END)

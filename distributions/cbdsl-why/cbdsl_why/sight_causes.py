"""Causes of sight: objects that were never seen, lost, occluded or ambiguous."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from cbdsl_why.history import FailureCause, History, Mask

# Time before a loss in which the kind of sight counts, s.
_BEFORE = 0.5


def sight(history: History) -> Iterator[FailureCause]:
    """Yield a cause for each signal of an object that a member needed and lacked to the end."""
    needs: dict[str, tuple[str, Mask]] = {}
    for course in history.courses:
        for signal in (course.feedback, course.base):
            if course.member and history.channels(signal):
                lacks = history.lacks(course) & ~history.defined[signal]
                if lacks.any():
                    needs.setdefault(signal, (course.name, lacks))
    for signal, (name, lacks) in {**dict(_conditions(history)), **needs}.items():
        defined = np.flatnonzero(history.defined[signal])
        seen_last = int(defined[-1]) if len(defined) else -1
        until = int(np.flatnonzero(lacks)[-1])
        if until > seen_last:
            yield _absence(history, signal, name, (seen_last, until))


def _conditions(history: History) -> Iterator[tuple[str, tuple[str, Mask]]]:
    """Yield positions that are undefined while a condition is, with its name and these ticks.

    A condition is a member that neither a controller nor a used program determines.
    """
    leads = {(e.program.rstrip("."), e.member) for e in history.courses if e.member}
    uses = {each.get("use", "") for each in history.transitions}
    for each in history.transitions:
        use, tick = each.get("use", ""), history.tick(each["time"])
        for name, letter in zip(history.recorded.members(each), each["next_state"], strict=False):
            if letter != "-" or (use, name) in leads or f"{use}.{name}".lstrip(".") in uses:
                continue
            for signal in history.places:
                lacks = np.zeros(len(history.time), dtype=bool)
                lacks[tick] = not history.defined[signal][tick]
                if lacks.any():
                    yield signal, (name, lacks)


def _absence(history: History, signal: str, name: str, ticks: tuple[int, int]) -> FailureCause:
    """Return the cause of a signal by its last ticks of definition, -1 for never, and of need."""
    seen_last, until = ticks
    channel = history.channels(signal)[0]
    codes = history.sight(channel)
    first = seen_last + 1
    need = f"and {name} needs {signal}"
    if seen_last < 0:
        counts = Counter(codes)
        # Images that match nowhere are a premise's matter, which suspends this cause.
        if counts["unmatched"] > counts["ambiguous"]:
            clause = f"each camera saw one {channel} region, and not at one position, {need}"
            return FailureCause("ambiguous", codes.index("unmatched"), clause)
        if counts["ambiguous"] > counts["partly"]:
            tick = codes.index("ambiguous")
            clause = f"both cameras saw {channel}, but no pair of regions was one object, {need}"
            return FailureCause("ambiguous", tick, clause, {"ticks": counts["ambiguous"]})
        if counts["partly"]:
            tick, clause = codes.index("partly"), f"only one camera saw {channel}, {need}"
            return FailureCause("occluded", tick, clause, {"ticks": counts["partly"]})
        return FailureCause("never_seen", 0, f"{channel} was never seen, {need}")
    # The position was remembered for a while after the last sighting.
    shown = [n for n in range(first) if codes[n : n + 1] not in (["hidden"], ["missing"])]
    tick = min((shown or [-1])[-1] + 1, history.last)
    at = float(history.time[max(0, tick - 1)])
    numbers = {"last": at}
    if codes[until : until + 1] in (["hidden"], ["partly"]):
        clause = f"{channel} was occluded, last seen at {at:.2f} s, {need}"
        return FailureCause("occluded", tick, clause, numbers)
    before = codes[max(0, seen_last - history.ticks(_BEFORE)) : first]
    if "several" in before or codes[until : until + 1] == ["ambiguous"]:
        clause = f"{channel} could not be told from another object of its colour"
        return FailureCause("ambiguous", tick, f"{clause} from {at:.2f} s on, {need}", numbers)
    clause = f"{channel} was lost, last seen at {at:.2f} s, {need}"
    return FailureCause("lost", tick, clause, numbers)

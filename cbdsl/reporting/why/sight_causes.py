"""Causes of sight: objects that were never seen, lost, occluded or ambiguous."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from cbdsl.reporting.why.history import FailureCause, History, Mask

# Time before a loss in which the kind of sight counts, s.
_BEFORE = 0.5


def sight(history: History) -> Iterator[FailureCause]:
    """Yield a cause for each signal of an object that a member needed and lacked to the end."""
    needs: dict[str, tuple[str, Mask]] = {}
    for course in history.courses:
        for signal in (course.feedback, course.base):
            if course.member and history.channels(signal):
                lacks = (course.letters == "-") & ~history.defined[signal]
                if lacks.any():
                    needs.setdefault(signal, (course.name, lacks))
    for signal, (name, lacks) in needs.items():
        defined = np.flatnonzero(history.defined[signal])
        seen_last = int(defined[-1]) if len(defined) else -1
        if np.flatnonzero(lacks)[-1] > seen_last:
            yield _absence(history, signal, name, seen_last)


def _absence(history: History, signal: str, name: str, seen_last: int) -> FailureCause:
    """Return the cause of a signal that was last defined in a tick, -1 for never."""
    channel = history.channels(signal)[0]
    codes = history.sight(channel)
    first = seen_last + 1
    need = f"and {name} needs {signal}"
    if seen_last < 0:
        counts = Counter(codes)
        if counts["ambiguous"]:
            tick = codes.index("ambiguous")
            clause = f"both cameras saw {channel}, but no pair of regions was one object, {need}"
            return FailureCause("ambiguous", tick, clause, {"ticks": counts["ambiguous"]})
        if counts["partly"]:
            tick, clause = codes.index("partly"), f"only one camera saw {channel}, {need}"
            return FailureCause("occluded", tick, clause, {"ticks": counts["partly"]})
        return FailureCause("never_seen", 0, f"{channel} was never seen, {need}")
    at = history.time[seen_last]
    before = codes[max(0, seen_last - history.ticks(_BEFORE)) : first]
    if "hidden" in before or "partly" in codes[first:]:
        hidden = next((n for n in range(seen_last, -1, -1) if codes[n] != "hidden"), 0) + 1
        seen = f"last seen at {history.time[hidden - 1]:.2f} s"
        clause = f"{channel} was occluded and then forgotten, {seen}, {need}"
        return FailureCause("occluded", min(hidden, first), clause, {"last": float(at)})
    if "several" in before or "ambiguous" in codes[first : first + history.ticks(_BEFORE)]:
        clause = f"{channel} could not be told from another object of its colour"
        return FailureCause(
            "ambiguous", first, f"{clause} from {at:.2f} s on, {need}", {"last": float(at)}
        )
    clause = f"{channel} was lost, last seen at {at:.2f} s, {need}"
    return FailureCause("lost", first, clause, {"last": float(at)})

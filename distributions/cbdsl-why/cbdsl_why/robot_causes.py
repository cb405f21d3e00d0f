"""Causes outside of the program: interrupts, errors, late ticks, and joints that do not follow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cbdsl_why.history import HALT, FailureCause, History, spans

# A joint lags if it is this share of the largest lead behind its reference for this long, s.
_LAG, _LAG_TIME = 0.5, 0.3
# Ticks in which a joint that follows reaches its reference.
_AGES = 3
# Share of the ticks until the end in which a joint that does not follow lags.
_MOSTLY = 0.5
# Force of a load cell above which a hand is in contact, N; contacts hold joints back.
_CONTACT = 0.3


def robot(history: History) -> Iterator[FailureCause]:
    """Yield the halt of an episode, and joints that do not follow their references."""
    if history.result.get("halted"):
        kind = "interrupted" if history.result["ending"].startswith("Interrupted") else "backend"
        yield FailureCause(kind, history.last, history.result["ending"].rstrip("."), rank=HALT)
    yield from _lagging(history)


def _lagging(history: History) -> Iterator[FailureCause]:
    arrays, lead = history.recorded.arrays, history.summary["robot"].get("lead")
    if not lead:
        return
    # A joint that moves on is where its reference was a moment ago.
    references, positions = arrays["references"], arrays["positions"]
    earlier = [references[np.maximum(np.arange(len(positions)) - age, 0)] for age in range(_AGES)]
    lag = np.min([np.abs(each - positions) for each in earlier], axis=0)
    forces = [np.zeros(len(lag)), *map(history.forces, history.hands)]
    lag[np.max(forces, axis=0) > _CONTACT] = 0.0
    for joint, name in enumerate(history.summary["joints"]):
        late = lag[:, joint] > _LAG * lead
        ticks = [first for first, last in spans(late) if last - first >= history.ticks(_LAG_TIME)]
        # A joint that catches up was only slow. References restart at each action.
        if ticks and late[ticks[0] :].mean() > _MOSTLY and late[-history.ticks(1.0) :].any():
            first = max(ticks[0] - _AGES + 1, 0)
            worst = float(lag[first:, joint].max())
            behind = f"{worst:.2f} {history.unit(joint)} behind its reference"
            yield FailureCause(
                "not_followed",
                first,
                f"joint {name} stayed {behind} without a felt contact: its drive failed, or "
                "something stopped it",
                {"lag": worst},
            )

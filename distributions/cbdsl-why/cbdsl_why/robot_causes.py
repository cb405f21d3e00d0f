"""Causes outside of the program: interrupts, errors, late ticks, and joints that do not follow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cbdsl_why.history import AGES, HALT, FailureCause, History, Mask, spans

# A joint lags if it is this share of the largest lead behind its reference for this long, s.
_LAG, _LAG_TIME = 0.5, 0.3
# Lag of a joint that begins to stop, as a share of the largest lead.
_RISES = 0.1
# Motion of a joint that stands still, as a share of the largest lead.
_STANDS = 0.25
# Share of the ticks until the end in which a joint that does not follow lags.
_MOSTLY = 0.5


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
    positions = arrays["positions"]
    lag = np.where(history.touches[:, None], 0.0, history.lags)
    stops = list(_stops(history, lag > _LAG * lead))
    for joint, name in enumerate(history.summary["joints"]):
        late = lag[:, joint] > _LAG * lead
        ticks = [first for first, last in spans(late) if last - first >= history.ticks(_LAG_TIME)]
        # A joint that catches up was only slow. References restart at each action.
        if ticks and late[ticks[0] :].mean() > _MOSTLY and late[-history.ticks(1.0) :].any():
            # It stopped when its lag began to grow.
            rises = np.flatnonzero(lag[: ticks[0], joint] <= _RISES * lead)
            first = max((int(rises[-1]) if len(rises) else ticks[0]) - AGES + 2, 0)
            # An object that stops an arm holds several of its joints back.
            if any(pushes[first:].mean() > _MOSTLY and joint in joints for pushes, joints in stops):
                continue
            # Another load or another reading lets a joint move on.
            if np.ptp(positions[first:, joint]) > _STANDS * lead:
                continue
            worst = float(lag[first:, joint].max())
            behind = f"{worst:.2f} {history.unit(joint)} behind its reference"
            yield FailureCause(
                "not_followed",
                first,
                f"joint {name} stayed {behind} without a felt contact: its drive failed, or "
                "something stopped it",
                {"lag": worst},
            )


def _stops(history: History, late: Mask) -> Iterator[tuple[Mask, list[int]]]:
    """Yield the ticks in which several joints of an arm push at an object, and its joints."""
    for hand in history.hands:
        joints = history.arm_joints(hand)
        yield history.pushes(hand) & (late[:, joints].sum(axis=1) > 1), joints

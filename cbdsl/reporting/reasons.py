"""Reasons why an episode stopped: missing signals, blocked levels, guards and joint limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cbdsl.reporting.recorded import Recorded

#: Duration of the examined end of an episode, s.
_LOOKED_AT = 0.5
# A level that achieves a smaller share of its task velocity is reported.
_SMALL_SHARE = 0.5
# A level at rest is not reported if its potential is at most this share of its maximum.
_SMALL_PHI = 1e-4


# The examined end covers half a second, because values of a single tick change with contacts and
# noise. Its last tick is the last one in which a controller acted, since a run may end later. A
# missing signal comes first: it explains why a controller did not act at all. Blocked levels
# follow, then guards and joint limits, which may hold without blocking anything.
def reasons(recorded: Recorded) -> list[str]:
    """Return sentences, the most informative first; none if nothing blocked the episode."""
    end = _last_ticks(recorded)
    stopped = (*_guards(recorded, end), *_limits(recorded, end))
    return [*_missing(recorded), *_held(recorded, end), *stopped]


def _last_ticks(recorded: Recorded) -> NDArray[np.intp]:
    """Return indices of the last ticks in which any controller acted."""
    time = recorded.arrays["time"]
    acted = np.flatnonzero((recorded.arrays["level_priority"] >= 0).any(axis=1))
    late = time[acted] > time[acted[-1:]] - _LOOKED_AT
    last: NDArray[np.intp] = acted[late]
    return last


def _missing(recorded: Recorded) -> Iterator[str]:
    """Yield sentences about the signals that controllers lacked in the last tick."""
    triples, signals = recorded.summary["triples"], recorded.signals
    last = recorded.summary["predicates"][-1]
    for name, predicate in zip(recorded.controllers, last, strict=True):
        if predicate != "-":
            continue
        inputs = [triples[name]["feedback"], triples[name]["reference"]]
        gone = [each for each in inputs if each in signals and np.isnan(signals[each][-1]).all()]
        if gone:
            yield f"{name} had no {' and no '.join(gone)}{_last_seen(recorded, gone[0])}."
        else:
            alone = "without a held object its effector does not move its feedback"
            yield f"{name} was undefined: {alone}."


def _last_seen(recorded: Recorded, signal: str) -> str:
    values = recorded.signals[signal]
    defined = ~np.isnan(values.reshape(len(values), -1)).all(axis=1)
    if not defined.any():
        return " in the whole episode"
    last = recorded.arrays["time"][np.flatnonzero(defined)[-1]]
    return f", last at {last:.1f} s"


def _held(recorded: Recorded, end: NDArray[np.intp]) -> Iterator[str]:
    """Yield sentences about levels with a small share of their task, highest priority first."""
    arrays, names = recorded.arrays, recorded.controllers
    if not len(end):
        return
    priority = arrays["level_priority"][end[-1]]
    for column in sorted(np.flatnonzero(priority >= 0), key=lambda each: priority[each]):
        acting = end[arrays["level_priority"][end, column] >= 0]
        share = float(np.median(arrays["level_share"][acting, column]))
        phi, largest = arrays["potentials"][acting[-1], column], _largest(recorded, int(column))
        if share >= _SMALL_SHARE or not abs(phi) > _SMALL_PHI * largest:
            continue
        yield (
            f"{names[column]} {_achieved(share)}, "
            f"{_cause(recorded, int(acting[-1]), int(column))} (φ stayed at {phi:.3g})."
        )


def _largest(recorded: Recorded, column: int) -> float:
    potentials = np.abs(recorded.arrays["potentials"][:, column])
    return float(np.nanmax(potentials, initial=0.0))


def _achieved(share: float) -> str:
    if share < -0.005:
        return "was moved away from what it wanted"
    return f"got {100 * abs(share):.0f} % of what it wanted"


def _cause(recorded: Recorded, tick: int, column: int) -> str:
    """Return the cause that kept a level from moving, as a clause."""
    arrays, names = recorded.arrays, recorded.controllers
    # Indices of controllers are followed by those of joint limits, of a local optimum and of a
    # singular posture; -1 is none.
    holder = int(arrays["level_held_by"][tick, column])
    if holder == len(names):
        return "because joints were at their limits"
    if holder > len(names):
        place = "a local optimum" if holder == len(names) + 1 else "a singular posture"
        return f"because it was at {place}, where no motion brought it nearer"
    if holder >= 0:
        return f"because {names[holder]} above it needed the same joints"
    if arrays["level_rank"][tick, column] == 0:
        return "because none of its directions was left"
    smallest = arrays["level_singular_value"][tick, column]
    if smallest < recorded.summary["robot"]["singular_value"]:
        return f"close to a singularity: its smallest singular value was {smallest:.2g}"
    return "because its step was as long as a step may be"


def _guards(recorded: Recorded, end: NDArray[np.intp]) -> Iterator[str]:
    """Yield a sentence about guards that the motion gave way to in the last ticks."""
    if "guard_held" not in recorded.arrays or not recorded.summary.get("guards"):
        return
    held = np.flatnonzero(recorded.arrays["guard_held"][end].any(axis=0))
    names = [recorded.summary["guards"][index] for index in held]
    if names:
        yield f"Gave way to the guards of: {', '.join(names)}."


def _limits(recorded: Recorded, end: NDArray[np.intp]) -> Iterator[str]:
    """Yield a sentence about joints at their limits in the last ticks."""
    held = np.flatnonzero(recorded.arrays["at_limits"][end].any(axis=0))
    names = [recorded.summary["joints"][index] for index in held]
    if names:
        yield f"At their limits: {', '.join(names)}."

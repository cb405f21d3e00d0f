"""One tick of the control law against the textbook: a pseudoinverse and a projector per level.

Run with ``python benchmarks/control_tick.py``. Both solve the same random stacks of three levels
on 14 joints (a 3-D reach, a posture of 7 joints, one further row), turn by turn in one process.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable, Sequence
from time import perf_counter

import numpy as np

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.control.signal import Floats

JOINTS = 14
STACKS = 200
ROUNDS = 20


def stack(rng: np.random.Generator) -> list[Level]:
    """Reach and posture on the first seven joints, the last row on all of them."""
    arm = np.eye(7, JOINTS)
    return [
        Level("reach", rng.uniform(-0.6, 0.6, (3, 7)) @ arm, rng.normal(size=3) * 1e-3),
        Level("posture", arm, rng.normal(size=7) * 1e-3),
        Level("manipulability", rng.normal(size=(1, JOINTS)), rng.normal(size=1) * 1e-3),
    ]


def textbook(levels: Sequence[Level], q: Floats) -> Floats:
    """J^# and I - J^# J, level by level; without limits, bounds or damping."""
    displacement, projector = np.zeros(len(q)), np.eye(len(q))
    for level in levels:
        rows = level.jacobian @ projector
        inverse = np.linalg.pinv(rows, rcond=1e-10)
        displacement = displacement + inverse @ (level.velocity - level.jacobian @ displacement)
        projector = projector - inverse @ rows
    return displacement


def microseconds(solve: Callable[[Sequence[Level], Floats], object], levels: list[Level]) -> float:
    """Time of one call."""
    q = np.zeros(JOINTS)
    start = perf_counter()
    solve(levels, q)
    return (perf_counter() - start) * 1e6


def main() -> None:
    """Time both and print medians and their ratio."""
    rng = np.random.default_rng(0)
    stacks = [stack(rng) for _ in range(STACKS)]
    limits = np.full(JOINTS, 3.0)
    law = Law(-limits, limits, LawSettings(joint_step=1.5 / 120)).solve
    times: dict[str, list[float]] = {"law": [], "pinv": []}
    for _ in range(ROUNDS):
        for levels in stacks:
            times["law"].append(microseconds(law, levels))
            times["pinv"].append(microseconds(textbook, levels))
    ours, theirs = (statistics.median(times[name]) for name in ("law", "pinv"))
    sys.stdout.write(
        f"control law {ours:.0f} us, np.linalg.pinv {theirs:.0f} us a tick, "
        f"ratio {theirs / ours:.1f}\n"
    )


if __name__ == "__main__":
    main()

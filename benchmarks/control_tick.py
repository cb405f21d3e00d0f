"""One tick of the control law against the textbook: a pseudoinverse and a projector per level.

Both solve the same random stacks of three levels on 14 joints, in turn in one process. The levels
are a 3-D reach, a posture of 7 joints, and one further row.

The law writes its levels into a stack that is allocated once, as controllers do in a running
program. ``Law.solve`` builds the stack for every call if levels have no past, which takes two
thirds of its time: 0.29 of the textbook's time with it, 0.11 without. The number of threads of
BLAS, the caches and the sizes do not explain that difference.

    python benchmarks/control_tick.py
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from collections.abc import Callable
from time import perf_counter

import numpy as np
from ours import Rows, law

from cbdsl.numeric.arrays import Floats

SIZES = (3, 7, 1)
JOINTS = 14
STACKS = 200
ROUNDS = 20


def stack(rng: np.random.Generator) -> Rows:
    """Return reach and posture on the first seven joints, the last row on all of them."""
    arm = np.eye(7, JOINTS)
    jacobians = rng.uniform(-0.6, 0.6, (3, 7)) @ arm, arm, rng.normal(size=(1, JOINTS))
    return [(rows, rng.normal(size=len(rows)) * 1e-3) for rows in jacobians]


def textbook(levels: Rows, q: Floats) -> Floats:
    """Apply J^# and I - J^# J, level by level; without limits, bounds or damping."""
    # Recursion over the levels i, with the pseudoinverse of each Jacobian in the null space above:
    #     dq <- dq + (J_i P)^# (dx_i - J_i dq),
    #     P  <- P - (J_i P)^# J_i P
    # (Siciliano and Slotine, A general framework for managing multiple tasks in highly redundant
    # robotic systems, 1991).
    displacement, projector = np.zeros(len(q)), np.eye(len(q))
    for jacobian, wanted in levels:
        rows = jacobian @ projector
        # The levels above leave the posture too few joints, so that rounding errors replace zeros
        # among the singular values. Their inverses would be huge.
        inverse = np.linalg.pinv(rows, rcond=1e-10)
        displacement = displacement + inverse @ (wanted - jacobian @ displacement)
        projector = projector - inverse @ rows
    return displacement


def microseconds(solve: Callable[[Rows, Floats], object], levels: Rows) -> float:
    """Return the time of one call."""
    q = np.zeros(JOINTS)
    start = perf_counter()
    solve(levels, q)
    return (perf_counter() - start) * 1e6


def main() -> None:
    """Time both and print medians and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    stacks = [stack(rng) for _ in range(STACKS)]
    solvers = {"law": law(SIZES, JOINTS), "pinv": textbook}
    times: dict[str, list[float]] = {name: [] for name in solvers}
    for _ in range(ROUNDS):
        for levels in stacks:
            for name, solve in solvers.items():
                times[name].append(microseconds(solve, levels))
    medians = {name: statistics.median(values) for name, values in times.items()}
    ratio = medians["law"] / medians["pinv"]
    if options.json:
        sys.stdout.write(json.dumps({"microseconds": medians, "ratio": round(ratio, 3)}) + "\n")
        return
    sys.stdout.write(
        f"control law {medians['law']:.0f} us, np.linalg.pinv {medians['pinv']:.0f} us a tick, "
        f"{ratio:.2f} of it\n"
    )


if __name__ == "__main__":
    main()

"""Predictions of a schema on all sides of its reach, before any motion of an arm.

In each context the robot looks, and the schema's tree of reward predicts whether an allocation is
rewarded. Then every allocation is tried. A prediction is right if it agrees with the outcome of
these tries. Shares have exact (Clopper-Pearson) 95 % intervals. The exit status is 1 if a share
misses its aim.

    python benchmarks/reach.py --seed 1 [--contexts 60] [--schema reachtouch]
        [--stage reach_on_all_sides] [--backend kinematic] [--cameras ideal] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Sequence

from cbdsl.api.run_request import read_request
from cbdsl.numeric.proportion import exact_interval
from cbdsl.types.decision_tree import Tree, decide
from schemas import Case, cases, prepared

# Least share of right predictions on each side.
AIM = 0.9


def is_right(reward: Tree[float], case: Case) -> bool:
    """Return whether a tree of reward predicts the outcome of a context."""
    return ((decide(reward, case.features) or 0.0) >= 0.5) == bool(case.works)


def summarise(side: str, reward: Tree[float], held_out: Sequence[Case]) -> dict[str, object]:
    """Return one row of the table.

    Args:
        side: Name of the stage's context.
        reward: Schema's tree of Pr(reward | pi, f).
        held_out: Cases of this context.
    """
    right = sum(is_right(reward, case) for case in held_out)
    low, high = exact_interval(right, len(held_out))
    return {
        "side": side,
        "contexts": len(held_out),
        "rewarded": sum(bool(case.works) for case in held_out),
        "right": right,
        "interval": [round(low, 3), round(high, 3)],
        "met": right >= AIM * len(held_out),
    }


def main() -> int:
    """Predict, try and print; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=8_500_000)
    parser.add_argument("--contexts", type=int, default=60, help="in total of each side")
    parser.add_argument("--schema", default="reachtouch", help="name or file")
    parser.add_argument("--program", default="reachtouch")
    parser.add_argument("--policy", default="reachtouch")
    parser.add_argument("--stage", default="reach_on_all_sides")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--cameras", choices=("rendered", "ideal"))
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    request = read_request(options.program, options.stage, None, {}, schema=options.schema)
    assert request.program.schema is not None
    assert request.program.schema.reward is not None
    reward, sides = request.program.schema.reward, len(request.stage.contexts)
    program, runner, watcher = prepared(options, options.backend, options.cameras)
    seeds = range(options.seed, options.seed + sides * options.contexts)
    by_side: dict[str, list[Case]] = defaultdict(list)
    for case in cases(program, runner, watcher, seeds):
        by_side[case.context].append(case)
    rows = [summarise(side, reward, by_side[side]) for side in request.stage.contexts]
    for row in rows:
        words = (f"{key} {value}" for key, value in row.items())
        print(json.dumps(row) if options.json else "  ".join(words), flush=True)
    return 0 if all(row["met"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())

"""Stability of stacks of the source's objects: ``stack`` and ``stack_three``.

The simulator judges. A stack stands if, at least 1 s after the release, each object rests and
touches its neighbours in the stack and nothing else. The pace of the release is the largest speed
of the object within 0.2 s after the last fingertip left it. Shares are of all episodes, with exact
(Clopper-Pearson) 95 % intervals, beside those of Tables 7.1 and 7.2. The exit status is 1 if flat
on flat stays in fewer than 95 %.

    python benchmarks/stacks.py --episodes 40 --seed 8500000 [--only purple_box_on_blue_box]
        [--backend bullet] [--cameras rendered] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from cbdsl.numeric.proportion import exact_interval
from cbdsl_reproduction.stack_trials import StackTrial, run_stacks
from cbdsl_reproduction.table_7_1 import STACKS

FLAT, TARGET = "purple_box_on_blue_box", 0.95


def summarise(name: str, trials: Sequence[StackTrial]) -> dict[str, Any]:
    """Return one row of the table."""
    stand = sum(each.stands for each in trials)
    released = [each for each in trials if each.released]
    return {
        "stack": name,
        "episodes": len(trials),
        "released": len(released),
        "stands": stand,
        "interval": [round(bound, 3) for bound in exact_interval(stand, len(trials))],
        "source_percent": STACKS[name],
        "offset_mm": _median([each.offset for each in released]),
        "pace_mm_s": _median([each.pace for each in released]),
        "amiss": [(each.seed, each.ending[:60]) for each in trials if not each.stands],
        "met": name != FLAT or stand >= TARGET * len(trials),
    }


def _median(values: Sequence[float]) -> float | None:
    """Return the median in thousandths."""
    return round(1e3 * float(np.median(values)), 1) if values else None


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=40, help="of each stack")
    parser.add_argument("--seed", type=int, default=8500000)
    parser.add_argument("--only", default=",".join(STACKS), help="some of the stacks")
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.episodes)
    rows = []
    for name in options.only.split(","):
        trials = list(run_stacks(name, seeds, options.backend, options.cameras))
        rows.append(summarise(name, trials))
        if not options.json:
            print("\n".join(f"{k}: {v}" for k, v in rows[-1].items()), flush=True)
    if options.json:
        print(json.dumps(rows))
    sys.exit(not all(row["met"] for row in rows))


if __name__ == "__main__":
    main()

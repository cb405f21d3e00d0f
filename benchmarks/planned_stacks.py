"""Success rate of stacks of three that are planned from a meta-catalog alone.

In each trial three objects of the meta-catalog lie on the table in a random order. The plan is the
most probable path through the pairs known to stand; ``stack_three`` is bound to the channels of the
objects on it. The simulator judges. The exit status is 1 if fewer than half of the stacks stand.

    python benchmarks/planned_stacks.py --trials 20 --seed 8950000 [--catalog four_things]
        [--backend bullet] [--cameras rendered] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence

from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.numeric.proportion import exact_interval
from cbdsl.yaml_text.library import Library
from cbdsl_reproduction.planned_stacks import PlannedStack, run_planned

TARGET = 0.5


def summarise(trials: Sequence[PlannedStack]) -> dict[str, object]:
    """Return one row."""
    stand = sum(each.stands for each in trials)
    return {
        "trials": len(trials),
        "stand": stand,
        "interval": [round(bound, 3) for bound in exact_interval(stand, len(trials))],
        "expected": round(sum(each.expected for each in trials), 1),
        "amiss": [(each.seed, each.things, each.ending[:80]) for each in trials if not each.stands],
        "met": stand >= TARGET * len(trials),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--seed", type=int, default=8950000)
    parser.add_argument("--catalog", default="four_things", help="a meta-catalog, file or name")
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    library = Library()
    file = library.locate(MetaCatalogDocument, options.catalog)
    catalog = library.read(file, MetaCatalogDocument).document
    seeds = range(options.seed, options.seed + options.trials)
    trials = []
    for trial in run_planned(catalog, seeds, options.backend, options.cameras):
        trials.append(trial)
        if not options.json:
            word = "stands" if trial.stands else f"does not stand: {trial.ending}"
            print(f"{trial.seed} {' < '.join(trial.order)}: {word}", flush=True)
    row = summarise(trials)
    print(json.dumps(row) if options.json else "\n".join(f"{k}: {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()

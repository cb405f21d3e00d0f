"""Impedance of six pairs of objects, measured by the hand that set one on or into the other.

The profiles come from the sensed forces and the joint positions (Section 7.2). Twelve tests
track a load along an axis of the world frame, or about one through the palm, within a bounded
displacement. A sign is correct if a direction is tracked as in Figure 7.13; directions that
depend on friction are not judged. The exit status is 1 if fewer than 80 % of the signs of a pair
are correct. Signs of one profile depend on each other, so a profile counts once in the exact
(Clopper-Pearson) 95 % interval.

    python benchmarks/impedance.py --episodes 5 --seed 8400000 [--only box_on_box] [--json]
        [--backend bullet] [--cameras rendered] [--profiles FILE] [--others]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cbdsl.learning.impedance import DIRECTIONS
from cbdsl.numeric.proportion import exact_interval
from cbdsl_reproduction.impedance_trials import ImpedanceTrial, run_trials
from cbdsl_reproduction.thing_pairs import ALL_PAIRS, OTHER_PAIRS, PAIRS
from cbdsl_reproduction.trial_record import plain_data

TARGET = 0.8


def summarise(name: str, trials: Sequence[ImpedanceTrial]) -> dict[str, Any]:
    """Return one row of the table."""
    pair = ALL_PAIRS[name]
    whole = [each.profile for each in trials if each.profile.is_whole]
    rights = [pair.right(profile.tracked()) for profile in whole]
    right, signs = sum(map(sum, rights)), sum(map(len, rights))
    shares = [sum(own) / len(own) for own in rights]
    tests = [test for profile in whole for test in profile.tests]
    return {
        "pair": name,
        "episodes": len(trials),
        "whole": len(whole),
        "tracked": {d: sum(p.tracked()[d] for p in whole) for d in DIRECTIONS},
        "normalized": {
            d: round(sum(p.normalized()[d] for p in whole) / max(len(whole), 1), 3)
            for d in DIRECTIONS
        },
        "signs": signs,
        "right": right,
        "interval": [round(v, 3) for v in exact_interval(sum(shares), len(whole))]
        if whole
        else [0, 1],
        "most_mm": _most(test.displacement for test in tests if test.direction[1] == "P"),
        "most_mrad": _most(test.displacement for test in tests if test.direction[1] == "R"),
        "residue_mm": _most(test.residue for test in tests if test.direction[1] == "P"),
        "amiss": [(each.seed, each.ending) for each in trials if not each.profile.is_whole],
        "met": bool(signs and right >= TARGET * signs),
    }


def _most(values: Any) -> float:
    """Return the largest size, in thousandths."""
    return round(1e3 * max((abs(value) for value in values), default=0.0), 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=5, help="of each pair")
    parser.add_argument("--seed", type=int, default=8400000)
    parser.add_argument("--only", help="some of the pairs")
    parser.add_argument("--others", action="store_true", help="the pairs that are held out")
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--profiles", type=Path, help="where the profiles go, as JSON")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    pairs = OTHER_PAIRS if options.others else PAIRS
    names = options.only.split(",") if options.only else list(pairs)
    rows, profiles = [], []
    for name in names:
        seeds = range(options.seed, options.seed + options.episodes)
        trials = list(run_trials(name, seeds, options.backend, options.cameras))
        profiles += [plain_data(each) for each in trials]
        rows.append(summarise(name, trials))
        if options.profiles is not None:
            options.profiles.write_text(json.dumps(profiles, indent=1), encoding="utf-8")
        if not options.json:
            print("\n".join(f"{k}: {v}" for k, v in rows[-1].items()), flush=True)
    if options.json:
        print(json.dumps(rows))
    sys.exit(not all(row["met"] for row in rows))


if __name__ == "__main__":
    main()

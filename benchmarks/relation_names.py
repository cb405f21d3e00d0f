"""Relations between two objects, named from the impedance of pairs outside of the training set.

A tree is grown from the profiles of the six pairs of the source, as written by
``benchmarks/impedance.py --profiles FILE``. It names those of other pairs (``--others``). An
incomplete profile is not used for training, and counts as not named. The exit status is 1 if fewer
than 90 % are named correctly.

    python benchmarks/relation_names.py --known known.json ... --others others.json ... [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cbdsl.learning.catalogs.relation_tree import (
    NamedProfile,
    grow_relations,
    name_relation,
    tree_as_data,
)
from cbdsl.numeric.proportion import exact_interval
from cbdsl_reproduction.impedance_trials import ImpedanceTrial
from cbdsl_reproduction.thing_pairs import ALL_PAIRS
from cbdsl_reproduction.trial_record import read_record

TARGET = 0.9


def read(files: Sequence[Path]) -> list[ImpedanceTrial]:
    """Return all trials of some files.

    Raises:
        OSError: One of them cannot be read.
        ValueError: A file holds no trials; names the file and the reason.
    """
    trials = []
    for file in files:
        try:
            rows = json.loads(file.read_text(encoding="utf-8"))
            if not isinstance(rows, list):
                raise ValueError("no list of trials")
            trials += [read_record(ImpedanceTrial, row) for row in rows]
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from None
    return trials


def summarise(known: Sequence[ImpedanceTrial], others: Sequence[ImpedanceTrial]) -> dict[str, Any]:
    """Return the tree, and its names of the others."""
    whole = [each for each in known if each.profile.is_whole]
    tree = grow_relations(
        [NamedProfile(each.profile, ALL_PAIRS[each.things].relation) for each in whole]
    )
    names = [
        name_relation(tree, each.profile) if each.profile.is_whole else None for each in others
    ]
    right = sum(
        name == ALL_PAIRS[each.things].relation for name, each in zip(names, others, strict=True)
    )
    counts = Counter((each.things, str(name)) for name, each in zip(names, others, strict=True))
    return {
        "learned_from": len(whole),
        "others": len(others),
        "right": right,
        "interval": [round(bound, 3) for bound in exact_interval(right, len(others))],
        "names": {f"{pair}: {name}": count for (pair, name), count in sorted(counts.items())},
        "tree": tree_as_data(tree),
        "met": right >= TARGET * len(others),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--known", type=Path, nargs="+", required=True)
    parser.add_argument("--others", type=Path, nargs="+", required=True)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        row = summarise(read(options.known), read(options.others))
    except (OSError, ValueError) as error:
        parser.error(str(error))
    print(json.dumps(row) if options.json else "\n".join(f"{k}: {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()

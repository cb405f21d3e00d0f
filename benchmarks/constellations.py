"""Relations and pairs recognised from the constellation of two objects.

Each pair is stacked by ``stand``, and observed before and after. Four shares are counted:

- judged: agreement of the robot's own judgement, by which it explores, with the simulator's truth;
- on or beside: correct answers of the pair's model of a meta-catalog, before and after stacking;
- pair: standing pairs recognised among all known pairs by the constellation alone, and by the
  constellation with the offset; no channel identifies the objects.

The exit status is 1 if the robot takes a fallen object to stand, or if on or beside is correct in
fewer than 90 %.

    python benchmarks/constellations.py --episodes 8 --seed 8970000 [--catalog four_things]
        [--only football_on_blue_box] [--backend bullet] [--cameras rendered] [--json]
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.learning.pair_recognition import recognise
from cbdsl.numeric.affordance import AffordanceModel
from cbdsl.numeric.proportion import exact_interval
from cbdsl.program.catalog_models import pair_models
from cbdsl.yaml_text.library import Library
from cbdsl_reproduction.constellation_trials import (
    CHANNELS,
    ConstellationTrial,
    Features,
    run_constellations,
)

TARGET = 0.9
# The blue box does not fit a hand.
PAIRS = [f"{a}_on_{b}" for a in CHANNELS for b in CHANNELS if a != b and a != "blue_box"]


def vector(catalog: MetaCatalogDocument, pair: str, seen: Features, names: Sequence[str]) -> Any:
    """Return some features' components, in the order of a pair's model; ``None`` if one lacks."""
    own = [name for name in catalog.pairs[pair].features if name in names]
    if not own or any(name not in seen for name in own):
        return None
    return np.array([value for name in own for value in seen[name]])


def models(catalog: MetaCatalogDocument, names: Sequence[str]) -> dict[str, AffordanceModel]:
    """Return models of the pairs that ever stayed, over some of their features."""
    found = {}
    for pair, model in pair_models(catalog).items():
        place, chosen = 0, list[int]()
        for name, feature in catalog.pairs[pair].features.items():
            own = range(place, place + feature.components)
            place += feature.components
            chosen += own if name in names else []
        if chosen:
            found[pair] = model.over(chosen)
    return found


def share(right: int, of: int) -> dict[str, Any]:
    """Return a share with its interval."""
    return {"right": right, "of": of, "interval": [round(b, 3) for b in exact_interval(right, of)]}


def on_or_beside(
    catalog: MetaCatalogDocument, trials: Sequence[ConstellationTrial]
) -> dict[str, Any]:
    """Count how often a pair's own model is right about it, before and after."""
    known, right, of = models(catalog, ("constellation", "offset")), 0, 0
    for trial in trials:
        own = {trial.things: known[trial.things]} if trial.things in known else {}
        for seen, stands in ((trial.before, False), (trial.after, trial.stands)):
            features = vector(catalog, trial.things, seen, ("constellation", "offset"))
            if not own:
                continue
            said = features is not None and recognise(own, features).pair is not None
            right, of = right + (said == stands), of + 1
    return share(right, of)


def which_pair(
    catalog: MetaCatalogDocument, trials: Sequence[ConstellationTrial], names: Sequence[str]
) -> dict[str, Any]:
    """Count the pairs that the standing pairs are taken for."""
    known = models(catalog, names)
    taken: Counter[tuple[str, str]] = Counter()
    for trial in trials:
        if not trial.stands or trial.things not in known:
            continue
        features = vector(catalog, trial.things, trial.after, names)
        said = None if features is None else recognise(known, features).pair
        taken[trial.things, str(said)] += 1
    right = sum(count for (pair, said), count in taken.items() if pair == said)
    wrong = sorted((*key, count) for key, count in taken.items() if key[0] != key[1])
    confused = {f"{pair} for {said}": count for pair, said, count in wrong}
    return {**share(right, sum(taken.values())), "confused": confused}


def summarise(
    catalog: MetaCatalogDocument, trials: Sequence[ConstellationTrial]
) -> Mapping[str, Any]:
    """Return all counts."""
    judged = Counter((trial.judged, trial.stands) for trial in trials)
    told = on_or_beside(catalog, trials)
    return {
        "episodes": len(trials),
        "stand_and_judged_so": [judged[True, True], judged[True, True] + judged[False, True]],
        "do_not_and_judged_so": [judged[False, False], judged[False, False] + judged[True, False]],
        "missed": [(t.things, t.seed, t.ending[-60:]) for t in trials if t.judged != t.stands],
        "on_or_beside": told,
        "pair_by_constellation": which_pair(catalog, trials, ("constellation",)),
        "pair_by_both": which_pair(catalog, trials, ("constellation", "offset")),
        "met": not judged[True, False] and told["right"] >= TARGET * told["of"],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=8, help="of each pair")
    parser.add_argument("--seed", type=int, default=8970000)
    parser.add_argument("--only", default=",".join(PAIRS), help="some of the pairs")
    parser.add_argument("--catalog", default="four_things", help="a meta-catalog, file or name")
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    library = Library()
    file = library.locate(MetaCatalogDocument, options.catalog)
    catalog = library.read(file, MetaCatalogDocument).document
    seeds = range(options.seed, options.seed + options.episodes)
    trials: list[ConstellationTrial] = []
    for pair in options.only.split(","):
        trials += run_constellations(pair, seeds, options.backend, options.cameras)
    row = summarise(catalog, trials)
    print(json.dumps(row) if options.json else "\n".join(f"{k}: {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()

"""Relations and pairs recognised from the constellation of two objects.

Each pair is stacked by ``stand``, and observed before and after. No channel identifies the objects
of a standing pair that is recognised among all known pairs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cbdsl.api.control import Floats
from cbdsl.api.documents import MetaCatalogDocument
from cbdsl.api.learning import AffordanceModel, pair_models
from cbdsl.api.shipped import shipped_document
from cbdsl_reproduction.constellation_trials import (
    CHANNELS,
    PROGRAM,
    STAGE,
    ConstellationTrial,
    Features,
    run_constellations,
)
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.judges.pair_recognition import recognise

_CATALOG = "four_things"
_SHAPE, _BOTH = ("constellation",), ("constellation", "offset")
# The blue box does not fit a hand.
PAIRS = [f"{a}_on_{b}" for a in CHANNELS for b in CHANNELS if a != b and a != "blue_box"]


def vector(
    catalog: MetaCatalogDocument, pair: str, seen: Features, names: Sequence[str]
) -> Floats | None:
    """Return some features' components, in the order of a pair's model; ``None`` if one lacks."""
    own = [name for name in catalog.pairs[pair].features if name in names]
    if not own or any(name not in seen for name in own):
        return None
    return np.array([value for name in own for value in seen[name]])


def models(catalog: MetaCatalogDocument, names: Sequence[str]) -> dict[str, AffordanceModel]:
    """Return models of the pairs that ever stayed, over some of their features."""
    result = {}
    for pair, model in pair_models(catalog).items():
        place, chosen = 0, list[int]()
        for name, feature in catalog.pairs[pair].features.items():
            own = range(place, place + feature.components)
            place += feature.components
            chosen += own if name in names else []
        if chosen:
            result[pair] = model.over(chosen)
    return result


def outcomes(catalog: MetaCatalogDocument, trial: ConstellationTrial) -> dict[str, bool | None]:
    """Return the outcomes of a trial; impossible ones are ``None``."""
    pair, both = trial.things, models(catalog, _BOTH)
    # Only a standing stack can be rightly judged standing, so that fallen ones do not count there.
    result: dict[str, bool | None] = {
        "judged standing": trial.judged if trial.stands else None,
        "judged standing though fallen": trial.judged and not trial.stands,
        "beside, told before": None,
        "on or beside, told after": None,
        "pair by constellation": None,
        "pair by constellation and offset": None,
    }
    if pair in both:
        own = {pair: both[pair]}
        result["beside, told before"] = not _is_told(catalog, own, trial.before)
        result["on or beside, told after"] = _is_told(catalog, own, trial.after) == trial.stands
    for names, outcome in (
        (_SHAPE, "pair by constellation"), (_BOTH, "pair by constellation and offset"),
    ):  # fmt: skip
        known = models(catalog, names)
        if trial.stands and pair in known:
            features = vector(catalog, pair, trial.after, names)
            result[outcome] = features is not None and recognise(known, features).pair == pair
    return result


def _is_told(
    catalog: MetaCatalogDocument, own: Mapping[str, AffordanceModel], seen: Features
) -> bool:
    """Return whether a pair's own model says that the pair stands."""
    (pair,) = own
    features = vector(catalog, pair, seen, _BOTH)
    return features is not None and recognise(own, features).pair is not None


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each stacked pair."""
    catalog = shipped_document(MetaCatalogDocument, _CATALOG)
    for trial in run_constellations(condition.name, seeds, body.backend, body.cameras):
        yield EpisodeVerdict(trial.seed, outcomes(catalog, trial), float("nan"), trial.ending)


_AIMS = {
    "judged standing": ANY,
    "judged standing though fallen": NONE,
    "beside, told before": Aim(0.9),
    "on or beside, told after": Aim(0.9),
    "pair by constellation": ANY,
    "pair by constellation and offset": ANY,
}
JUDGE = Judge(
    "constellations",
    "relations and pairs recognised from the constellation of two objects",
    tuple(JudgedCondition(pair, PROGRAM, _AIMS, STAGE, pair) for pair in PAIRS),
    _measure,
    BodyChoice("mujoco", "ideal"),
    episodes=8,
)

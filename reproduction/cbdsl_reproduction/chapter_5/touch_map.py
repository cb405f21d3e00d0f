"""Touch map: positions at which the world affords touch (Figure 5.6).

Fifty places: 20 on the surface of a table, 20 at an object on it, and 10 on an object that the
first hand brings to the second (Section 5.2.2). Each is the position of contact of the fingertips
at the reward of an episode, by load cells and kinematics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.documents import BoxForm, Kernel, ModelDocument, StageDocument, write
from cbdsl.api.shipped import shipped_document
from cbdsl_reproduction.chapter_5.cross_sections import CrossSections
from cbdsl_reproduction.chapter_5.touch_trials import SOURCES, TouchTrial, touch_digest, toucher
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_trials import KeptTrials
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity, computed
from cbdsl_reproduction.region import at_least, below, between, near

Floats = NDArray[np.float64]

# Desired samples of each of five sources, fifty in all as in the dissertation.
_WANTED, _QUICK = 10, 2
# A source is given up after this number of episodes for each desired sample.
_PATIENCE = 3
_KINDS = ("table", "object", "bimanual")
# Standard deviation of the kernels in the picture, and the least of those in models, m.
_BANDWIDTH, _LEAST = 0.03, 0.003
# Height of the table in the dissertation, and its tolerance, m.
_TABLE, _WITHIN = -0.42, 0.01

_PLACE = "Section 5.2.2, Figure 5.6"
_REWARDED = {kind: Claim(_PLACE, f"{kind}: rewarded", "%", "no number") for kind in _KINDS}
_TABLE_HEIGHT = Claim(_PLACE, "table: height of touches", "m", "about -0.42", near(_TABLE, _WITHIN))
_OBJECT_HEIGHT = Claim(
    _PLACE,
    "object: height of touches above those of the table",
    "m",
    "slightly above it",
    between(0.0, 0.2, "above 0, up to 0.2"),
)
_BIMANUAL_HEIGHT = Claim(
    _PLACE,
    "bimanual: height of touches",
    "m",
    "slightly below 0",
    between(-0.1, 0.0, "-0.1 to 0"),
)
_OVER = Claim(_PLACE, "on the table or above it", "%", "all", at_least(90))
_PEAK = Claim(
    _PLACE,
    "from the highest peak to the bimanual touches",
    "m",
    "the large peak is theirs",
    below(0.05),
)
CLAIMS: Claims = {
    "fig-5.6": (
        *_REWARDED.values(),
        _TABLE_HEIGHT,
        _OBJECT_HEIGHT,
        _BIMANUAL_HEIGHT,
        _OVER,
        _PEAK,
    )
}

_NOTES = (
    "Programs touch_table and reachtouch, with the right arm and with the left, and bimanualtouch. "
    "A sample is the mean of the places at which fingertips felt contact when the episode was "
    "rewarded: where the line of force and torque leaves the round tip. Episodes without reward "
    "have none.",
    "The origin is in Dexter's chest. --keep FOLDER has each map as a model.",
)


def run(settings: RunSettings) -> Result:
    """Touch, and map the positions of contact."""
    trials = gather(settings)
    samples = by_kind(trials)
    for source, own in trials.items():
        places = _places(own)
        if len(places):
            write(document(source, places), settings.folder / f"touch_map_{source}.yaml")
    picture = CrossSections(
        "touch_map", "Where touch is afforded (Figure 5.6)", samples, _BANDWIDTH, _table()
    )
    return Result(tuple(quantities(trials, picture, settings.seed)), (picture,), _NOTES)


def gather(settings: RunSettings) -> dict[str, list[TouchTrial]]:
    """Run episodes of each source until it has yielded the desired number of samples."""
    wanted = _QUICK if settings.quick else settings.trials or _WANTED
    trials: dict[str, list[TouchTrial]] = {}
    total = wanted * len(SOURCES)
    path = settings.folder / f"touch_{settings.backend}_{settings.cameras}.jsonl"
    for name in SOURCES:
        kept = KeptTrials(path, touch_digest(name), TouchTrial)

        def tell(hits: int, before: int = wanted * len(trials)) -> None:
            settings.progress(before + hits, total)

        trials[name] = _gathered(name, settings, kept, wanted, tell)
    return trials


def _gathered(
    name: str,
    settings: RunSettings,
    kept: KeptTrials[TouchTrial],
    wanted: int,
    tell: Callable[[int], None],
) -> list[TouchTrial]:
    """Return stored and new episodes of one source, in the order of their seeds."""
    own: list[TouchTrial] = []
    hits, touch = 0, None
    with ExitStack() as stack:
        for seed in range(settings.seed, settings.seed + _PATIENCE * wanted):
            tell(hits)
            if hits == wanted:
                break
            trial = kept.get(name, seed)
            if trial is None:
                # The simulator starts only if an episode is missing.
                if touch is None:
                    opened = toucher(name, settings.backend, settings.cameras)
                    touch = stack.enter_context(opened)
                trial = touch(seed)
                kept.add(trial)
            own.append(trial)
            hits += bool(trial.place)
    return own


def by_kind(trials: Mapping[str, Sequence[TouchTrial]]) -> dict[str, Floats]:
    """Return the places on the table, at an object and of both hands, m, shape (k, 3)."""
    return {kind: _places(_of(kind, trials)) for kind in _KINDS}


def _of(kind: str, trials: Mapping[str, Sequence[TouchTrial]]) -> list[TouchTrial]:
    return [trial for name in trials if name.startswith(kind) for trial in trials[name]]


def _places(trials: Sequence[TouchTrial]) -> Floats:
    return np.array([trial.place for trial in trials if trial.place]).reshape(-1, 3)


def bandwidth(places: Floats) -> Floats:
    """Return standard deviations of kernels by Scott's rule (1992), m, shape (3,)."""
    count, axes = places.shape
    # The rule assumes a normal density. Touches of a level table
    # hardly differ in height, so that a least width is needed.
    wide: Floats = places.std(axis=0) * count ** (-1 / (axes + 4))
    return np.maximum(wide.round(3), _LEAST)


def document(source: str, places: Floats) -> ModelDocument:
    """Return the map of one source as a model for drawing position references."""
    own = SOURCES[source]
    return ModelDocument(
        cbdsl=1,
        kind="model",
        name=f"touch_map_{source}",
        description=f"Where {own.program} on {own.stage} was rewarded for touch (fig-5.6).",
        robot="dexter",
        effector=own.arm,
        space="position",
        density=Kernel(
            form="kernel",
            samples=tuple(tuple(place) for place in places.tolist()),
            bandwidth=tuple(bandwidth(places).tolist()),
        ),
    )


def quantities(
    trials: Mapping[str, Sequence[TouchTrial]], picture: CrossSections, seed: int
) -> Iterator[Quantity]:
    """Yield the positions of the samples beside the claims of the dissertation."""
    samples = picture.samples
    for kind in _KINDS:
        own = _of(kind, trials)
        hits = sum(1 for each in own if each.place)
        yield percentage(_REWARDED[kind], hits, len(own), of="episodes")
    table, thing, both = (samples[kind][:, 2] for kind in _KINDS)
    yield mean_of(_TABLE_HEIGHT, table.tolist(), seed=seed)
    # The height of the table is the measured one, so that a common error of all heights cancels.
    top = float(table.mean()) if len(table) else float("nan")
    yield mean_of(_OBJECT_HEIGHT, (thing - top).tolist(), seed=seed)
    yield mean_of(_BIMANUAL_HEIGHT, both.tolist(), seed=seed)
    yield _over_the_table(picture)
    yield _peak(picture)


def _over_the_table(picture: CrossSections) -> Quantity:
    places, (low, high) = picture.positions, picture.outline
    # Heights have claims of their own, so that only the outline of the table counts here.
    over = np.all((places[:, :2] >= low[:2]) & (places[:, :2] <= high[:2]), axis=1)
    return percentage(_OVER, int(over.sum()), len(over), of="samples")


def _peak(picture: CrossSections) -> Quantity:
    """Return the distance between the highest peak from above and the bimanual touches."""
    both = picture.samples["bimanual"]
    apart = float("nan")
    if len(both):
        apart = float(np.linalg.norm(picture.peak() - both[:, :2].mean(axis=0)))
    return computed(_PEAK, apart)


def _table() -> Floats:
    """Return the corners of the table that all stages share, m, shape (2, 3)."""
    table = shipped_document(StageDocument, "bare_table").fixtures["table"]
    assert isinstance(table.form, BoxForm)
    middle = np.array([first for first, _ in table.position])
    half = np.array([first for first, _ in table.form.size]) / 2
    return np.array((middle - half, middle + half))

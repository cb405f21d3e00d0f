"""Model-exploration programs: attention to unknown objects (Figures 6.6 to 6.8)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from cbdsl.api.documents import CatalogDocument
from cbdsl.api.learning import NOOP
from cbdsl_reproduction.chapter_6.action_counts import rewarded_claim, share_of_actions
from cbdsl_reproduction.chapter_6.habituation import (
    actions_of,
    change_chart,
    negligible_claim,
    negligible_reward,
    reward_chart,
    tries_until_habituated,
)
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import chance_of_samples, mean
from cbdsl_reproduction.experiment import Picture, Result, RunSettings
from cbdsl_reproduction.exploration_series import (
    NOVEL,
    TABLE_MODELS,
    THREE_BALLS,
    ExplorationSeries,
)
from cbdsl_reproduction.interval import bootstrap_interval
from cbdsl_reproduction.percentage import clustered_percentage, percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, at_least
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

_SERIES = {"fig-6.6": TABLE_MODELS, "fig-6.7": THREE_BALLS, "fig-6.8": NOVEL}
# The blue ball comes before the first of these actions, the red one moves before the second.
_COMES, _MOVES, _SOON = 25, 50, 5
_COLORS = ("red", "yellow", "blue")
_AS_PRINTED = {"red": "about 7", "yellow": "about 18", "blue": "about 27"}

_PLACES = {name: f"Section 6.3.1, Figure {name.removeprefix('fig-')}" for name in _SERIES}
_NEGLIGIBLE = negligible_claim(_PLACES["fig-6.6"], 20, 30)
_HABITUATES = {
    color: Claim(_PLACES["fig-6.7"], f"{color}: taken until habituated", "actions", report)
    for color, report in _AS_PRINTED.items()
}
_MORE = {
    (less, more): Claim(
        _PLACES["fig-6.7"],
        f"{more} minus {less}",
        "actions",
        f"{more} more than {less}",
        above(0.0),
    )
    for less, more in pairwise(_COLORS)
}
_TOUCHES = {
    color: Claim(
        _PLACES["fig-6.8"],
        f"touches the {color} ball, once it {event}, within {_SOON} actions",
        "%",
        "yes",
        at_least(90),
    )
    for color, event in (("blue", "is there"), ("red", "was moved"))
}
_IDLES = Claim(
    _PLACES["fig-6.8"],
    "noop in the 10 actions ahead of the blue ball",
    "%",
    "habituated",
    above(50),
)
_REWARDED = {name: rewarded_claim(place) for name, place in _PLACES.items()}
CLAIMS: Claims = {
    "fig-6.6": (_REWARDED["fig-6.6"], _NEGLIGIBLE),
    "fig-6.7": (_REWARDED["fig-6.7"], *_HABITUATES.values(), *_MORE.values()),
    "fig-6.8": (_REWARDED["fig-6.8"], *_TOUCHES.values(), _IDLES),
}


def run(settings: RunSettings, name: str) -> Result:
    """Explore, and measure the attention over time."""
    with trial_runner(settings) as dexter:
        catalogs = gather(dexter, settings, name)
    measure = {"fig-6.6": _table, "fig-6.7": _balls, "fig-6.8": _attention}[name]
    series, rewarded = _SERIES[name], _rewarded(name, catalogs)
    quantities = [*rewarded, *measure(catalogs, settings.seed)]
    pictures: list[Picture] = [reward_chart(name, series.label, catalogs)]
    change = change_chart(name, series.label, catalogs)
    return Result(tuple(quantities), (*pictures, *([change] if change else [])), _NOTES)


_NOTES = (
    "A model whose features are seen far from where it has them (4 Mahalanobis distances) counts "
    "as changing, and an action whose model is unknown or changing is worth 0.2 in a state in "
    "which it was not tried: without either, a program that does nothing in its learned states "
    "would attend to new or moved objects only by chance.",
)


def series_of(name: str) -> tuple[ExplorationSeries, ...]:
    """Return the series of explorations."""
    return (_SERIES[name],)


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> list[CatalogDocument]:
    """Run all actions, and return the catalog of each trial."""
    series = _SERIES[name]
    dexter.expect(len(dexter.numbers(series)) * dexter.actions(series))
    return dexter.explore(series)


def _rewarded(figure: str, catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    for name in dict.fromkeys(key for each in catalogs for key in each.affordances):
        yield share_of_actions(_REWARDED[figure], catalogs, name)


def _table(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    yield negligible_reward(_NEGLIGIBLE, catalogs, seed)


def _balls(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    """Yield the tries until habituation, which increase with the variance of a ball's place."""
    tries = {
        color: np.array([tries_until_habituated(each, f"reachtouch_{color}") for each in catalogs])
        for color in _COLORS
    }
    for color, own in tries.items():
        interval = bootstrap_interval(own.tolist()) if len(own) > 1 else None
        yield Quantity(_HABITUATES[color], float(own.mean()), interval)
    for (less, more), claim in _MORE.items():
        # The balls of a trial compete for the same actions,
        # so that differences within a trial are the samples.
        apart = tries[more] - tries[less]
        assert claim.region is not None
        yield Quantity(
            claim,
            float(apart.mean()),
            bootstrap_interval(apart.tolist()) if len(apart) > 1 else None,
            chance_of_samples(claim.region, apart, mean, seed),
        )


def _attention(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    """Yield the attention to the novel ball, and to the moved one."""
    for color, first in (("blue", _COMES), ("red", _MOVES)):
        name = f"reachtouch_{color}"
        # The change becomes visible at the end of the action that follows it.
        soon = [name in actions_of(each)[first : first + 1 + _SOON] for each in catalogs]
        yield percentage(_TOUCHES[color], sum(soon), len(soon))
    # A robot that never idles touches a new ball by chance as well.
    # Idling ahead of it shows that the known balls no longer attract.
    before = [actions_of(each)[_COMES - 10 : _COMES] for each in catalogs]
    idle, sizes = [own.count(NOOP) for own in before], [len(own) for own in before]
    yield clustered_percentage(_IDLES, idle, sizes)

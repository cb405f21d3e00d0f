"""Model-exploration programs: attention to unknown objects (Figures 6.6 to 6.8)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from cbdsl.api.documents import CatalogDocument
from cbdsl.api.learning import NOOP
from cbdsl_reproduction.chapter_6.action_counts import share_of_actions
from cbdsl_reproduction.chapter_6.habituation import (
    actions_of,
    change_chart,
    negligible_reward,
    reward_chart,
    tries_until_habituated,
)
from cbdsl_reproduction.claim import above, at_least
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
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

_SERIES = {"fig-6.6": TABLE_MODELS, "fig-6.7": THREE_BALLS, "fig-6.8": NOVEL}
# The blue ball comes before the first of these actions, the red one moves before the second.
_COMES, _MOVES, _SOON = 25, 50, 5
_COLORS = ("red", "yellow", "blue")
_AS_PRINTED = {"red": "about 7", "yellow": "about 18", "blue": "about 27"}


def run(settings: RunSettings, name: str) -> Result:
    """Explore, and measure the attention over time."""
    with trial_runner(settings) as dexter:
        catalogs = gather(dexter, settings, name)
    measure = {"fig-6.6": _table, "fig-6.7": _balls, "fig-6.8": _attention}[name]
    series, quantities = _SERIES[name], [*_rewarded(catalogs), *measure(catalogs, settings.seed)]
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


def _rewarded(catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    for name in dict.fromkeys(key for each in catalogs for key in each.affordances):
        yield share_of_actions(catalogs, name)


def _table(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    yield negligible_reward(catalogs, 20, 30, seed)


def _balls(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    """Yield the tries until habituation, which increase with the variance of a ball's place."""
    tries = {
        color: np.array([tries_until_habituated(each, f"reachtouch_{color}") for each in catalogs])
        for color in _COLORS
    }
    for color, own in tries.items():
        name, source = f"{color}: taken until habituated", _AS_PRINTED[color]
        interval = bootstrap_interval(own.tolist()) if len(own) > 1 else None
        yield Quantity(name, "actions", source, float(own.mean()), None, interval=interval)
    for less, more in pairwise(_COLORS):
        apart, claim = tries[more] - tries[less], above(0.0)
        yield Quantity(
            f"{more} minus {less}",
            "actions",
            f"{more} more than {less}",
            float(apart.mean()),
            claim,
            interval=bootstrap_interval(apart.tolist()) if len(apart) > 1 else None,
            chance=chance_of_samples(claim, apart, mean, seed),
        )


def _attention(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    """Yield the attention to the novel ball, and to the moved one."""
    for text, name, first in (
        ("the blue ball, once it is there", "reachtouch_blue", _COMES),
        ("the red ball, once it was moved", "reachtouch_red", _MOVES),
    ):
        # The change becomes visible at the end of the action that follows it.
        soon = [name in actions_of(each)[first : first + 1 + _SOON] for each in catalogs]
        label = f"touches {text}, within {_SOON} actions"
        yield percentage(label, "yes", sum(soon), len(soon), at_least(90))
    before = [actions_of(each)[_COMES - 10 : _COMES] for each in catalogs]
    idle, sizes = [own.count(NOOP) for own in before], [len(own) for own in before]
    name = "noop in the 10 actions ahead of the blue ball"
    yield clustered_percentage(name, "habituated", idle, sizes, above(50))

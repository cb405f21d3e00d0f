"""Three catalogs: affordances of a table and two balls (Figures 6.2 to 6.5)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cbdsl.api.documents import CatalogDocument
from cbdsl.api.drawing import Layer, catalog_icon
from cbdsl.api.learning import NOOP, CatalogConstants
from cbdsl_reproduction.chapter_6.action_counts import (
    action_bars,
    share_of_actions,
    tallies,
    tally,
)
from cbdsl_reproduction.chapter_6.habituation import (
    actions_of,
    change_chart,
    negligible_reward,
    reward_chart,
)
from cbdsl_reproduction.claim import Claim, above, at_least, at_most, below
from cbdsl_reproduction.estimate import chance_of_samples, mean
from cbdsl_reproduction.experiment import Picture, Result, RunSettings
from cbdsl_reproduction.exploration_series import (
    BASKETBALL,
    RED_BALL,
    TABLE,
    ExplorationSeries,
)
from cbdsl_reproduction.interval import bootstrap_interval
from cbdsl_reproduction.percentage import clustered_percentage, percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

# First and last actions of an exploration, among which doing nothing is rare and frequent.
_FIRST, _LAST = 30, 30


@dataclass(frozen=True)
class Expected:
    """Report of the source of one action on one object.

    Attributes:
        source: Report in a few words.
        claim: Claim about the percentage of rewarded actions.
    """

    source: str
    claim: Claim


_ALWAYS, _NEVER = Expected("100 %", at_least(95)), Expected("0 %", at_most(5))
#: Series and expected share of rewards of each action, by figure.
FIGURES: Mapping[str, tuple[ExplorationSeries, Mapping[str, Expected]]] = {
    "fig-6.2": (
        TABLE,
        {
            "searchtrack": _ALWAYS,
            "reachtouch": _ALWAYS,
            "bimanualtouch": _NEVER,
            "visualinspect": _NEVER,
        },
    ),
    "fig-6.3": (
        BASKETBALL,
        {
            "searchtrack": _ALWAYS,
            "reachtouch": Expected("about 90 %", at_least(90)),
            "bimanualtouch": Expected("about 75 %", at_least(75)),
            "visualinspect": _NEVER,
        },
    ),
    "fig-6.4": (RED_BALL, {"searchtrack": _ALWAYS}),
}
#: Actions that belong to each catalog.
_ICONS: Mapping[str, frozenset[str]] = {
    "table": frozenset({"searchtrack", "reachtouch"}),
    "basketball": frozenset({"searchtrack", "reachtouch", "bimanualtouch"}),
    "red_ball": frozenset(
        {
            "searchtrack",
            "reachtouch",
            "bimanualtouch",
            "visualinspect_blue",
            "visualinspect_yellow",
        }
    ),
}


def run(settings: RunSettings, name: str) -> Result:
    """Explore, and count the rewarded actions."""
    with trial_runner(settings) as dexter:
        explored = gather(dexter, settings, name)
    if name == "fig-6.5":
        return _icons(explored)
    series, catalogs = explored[0]
    expected = FIGURES[name][1]
    quantities = [
        *_shares(catalogs, expected),
        *(_marks(catalogs) if series is RED_BALL else ()),
        *_counts(catalogs),
        *_habituation(catalogs, settings.seed),
    ]
    pictures: list[Picture] = [
        reward_chart(name, series.label, catalogs),
        action_bars(name, series.label, catalogs),
    ]
    change = change_chart(name, series.label, catalogs)
    notes = (*_NOTES, schedule_of(series))
    return Result(tuple(quantities), (*pictures, *([change] if change else [])), notes)


_NOTES = (
    "Every action of every trial is carried out, with the robot's own signals; the source carried "
    "one trial out and drew the others from its models. The reward is relative to the largest "
    "change so far; relative to the largest of the whole trial, as the source has it, it is "
    "known only at the end, and drawn beside it.",
)


def schedule_of(series: ExplorationSeries) -> str:
    """Return the time limit of the actions and the exploration schedule of a series, as a note."""
    usual = CatalogConstants()
    longest = series.constants.get("longest", f"{usual.longest:g} s")
    return (
        f"An action has {longest}; {usual.longest:g} s is the default of cb explore. Softmax "
        f"begins at a temperature of {usual.temperature:g}, which falls by {usual.decay:g} an "
        f"action to {usual.coldest:g}; the source has 1 and 0.99."
    )


_ICON_NOTES = (
    "An icon shows the actions that were rewarded, with how often they were. The source draws one "
    "catalog of each object; here an icon counts over all trials.",
)


def series_of(name: str) -> tuple[ExplorationSeries, ...]:
    """Return the series of explorations."""
    return (TABLE, BASKETBALL, RED_BALL) if name == "fig-6.5" else (FIGURES[name][0],)


def gather(
    dexter: TrialRunner, settings: RunSettings, name: str
) -> list[tuple[ExplorationSeries, list[CatalogDocument]]]:
    """Run all actions, and return the catalogs of each series."""
    for series in series_of(name):
        dexter.expect(len(dexter.numbers(series)) * dexter.actions(series))
    return [(series, dexter.explore(series)) for series in series_of(name)]


def _shares(
    catalogs: Sequence[CatalogDocument], expected: Mapping[str, Expected]
) -> Iterator[Quantity]:
    for name, what in expected.items():
        yield share_of_actions(catalogs, name, what.source, what.claim)


def _marks(catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    """Yield the shares of inspections that find either of the two patches of a ball."""
    for name in ("reachtouch", "bimanualtouch"):
        yield share_of_actions(catalogs, name)
    names = dict.fromkeys(k for each in catalogs for k in each.affordances if "inspect" in k)
    inspected = [sum(tally([each], name)[1] for name in names) for each in catalogs]
    for name in names:
        if name != "visualinspect":
            label = f"{name} rewarded, of all inspections"
            hits, _ = tallies(catalogs, name)
            yield clustered_percentage(label, "below one half", hits, inspected, below(50))
    both = sum(
        {"visualinspect_blue", "visualinspect_yellow"} <= set(e.affordances) for e in catalogs
    )
    yield percentage("both patches found", "always", both, len(catalogs), at_least(90))


def _counts(catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    """Yield the mean number of times that each action was taken in a trial."""
    names = dict.fromkeys(a for each in catalogs for a in actions_of(each))
    for name in names:
        counts = np.array([float(actions_of(each).count(name)) for each in catalogs])
        interval = bootstrap_interval(counts.tolist()) if len(counts) > 1 else None
        yield Quantity(f"{name} taken", "", "", float(counts.mean()), None, interval=interval)


def _habituation(catalogs: Sequence[CatalogDocument], seed: int) -> Iterator[Quantity]:
    yield negligible_reward(catalogs, 40, 60, seed)
    more = np.array([_more_often(actions_of(each)) for each in catalogs])
    grows = above(0.0)
    yield Quantity(
        f"noop, last {_LAST} minus first {_FIRST} actions",
        "actions",
        "grows",
        float(more.mean()),
        grows,
        interval=bootstrap_interval(more.tolist()) if len(more) > 1 else None,
        chance=chance_of_samples(grows, more, mean, seed),
    )


def _more_often(actions: Sequence[str]) -> float:
    return float(actions[-_LAST:].count(NOOP) - actions[:_FIRST].count(NOOP))


@dataclass(frozen=True)
class IconPicture:
    """Icon of a catalog as a picture of an experiment."""

    name: str
    title: str
    feature: str
    layers: tuple[Layer, ...]

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        return catalog_icon(self.title, self.feature, self.layers)

    def data(self) -> dict[str, object]:
        """Return the data of the picture, for scripts."""
        return {each.name: [each.rewarded, each.tried] for each in self.layers}


def _icons(explored: Sequence[tuple[ExplorationSeries, list[CatalogDocument]]]) -> Result:
    quantities, pictures = [], []
    for series, catalogs in explored:
        wanted = _ICONS[series.name]
        hits = sum(_afforded(each) == wanted for each in catalogs)
        label = f"{series.label}: catalogs with just these {len(wanted)} affordances"
        quantities.append(percentage(label, "all", hits, len(catalogs), at_least(90)))
        keys = dict.fromkeys(k for each in catalogs for k in each.affordances)
        counts = {key: tally(catalogs, key) for key in keys}
        layers = tuple(Layer(key, tried, hits) for key, (hits, tried) in counts.items())
        pictures.append(IconPicture(f"fig-6.5-{series.name}", series.label, series.feature, layers))
    return Result(tuple(quantities), tuple(pictures), _ICON_NOTES)


def _afforded(catalog: CatalogDocument) -> frozenset[str]:
    """Return the actions that were rewarded at least once, without the open one of found marks."""
    rewarded = {name for name, each in catalog.affordances.items() if each.rewarded}
    # Example: ``visualinspect`` stands for marks of any colour. If ``visualinspect_blue`` was
    # rewarded as well, the latter alone counts.
    return frozenset(
        name for name in rewarded if not any(mark.startswith(f"{name}_") for mark in rewarded)
    )

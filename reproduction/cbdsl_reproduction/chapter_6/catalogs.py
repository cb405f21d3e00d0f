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
    rewarded_claim,
    share_of_actions,
    tallies,
    tally,
)
from cbdsl_reproduction.chapter_6.habituation import (
    actions_of,
    change_chart,
    negligible_claim,
    negligible_reward,
    reward_chart,
)
from cbdsl_reproduction.claim import Claim, Claims
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
from cbdsl_reproduction.region import ValueRegion, above, at_least, at_most, below
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

# First and last actions of an exploration, among which doing nothing is rare and frequent.
_FIRST, _LAST = 30, 30


@dataclass(frozen=True)
class Expected:
    """Report of the source of one action on one object.

    Attributes:
        report: Report in a few words.
        region: ValueRegion of the percentage of rewarded actions.
    """

    report: str
    region: ValueRegion


# The source carried out a single trial. Bounds of 95 and 5 %
# leave room for rare failures that one trial does not show.
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
_INSPECTED = ("visualinspect_blue", "visualinspect_yellow")
_GROWS = above(0.0)


@dataclass(frozen=True)
class CatalogClaims:
    """Claims about the exploration of one object.

    Attributes:
        place: Section and figure of the source.
        expected: Expected share of rewards of each action.
    """

    place: str
    expected: Mapping[str, Expected]

    def rewarded(self, action: str) -> Claim:
        """Return the claim about the share of rewards of an action."""
        own = self.expected.get(action)
        if own is None:
            return rewarded_claim(self.place, action)
        return rewarded_claim(self.place, action, own.report, own.region)

    @property
    def inspected(self) -> Claim:
        """Claim about the share of inspections that find one patch of a ball."""
        name = "{action} rewarded, of all inspections"
        return Claim(self.place, name, "%", "below one half", below(50))

    @property
    def both(self) -> Claim:
        """Claim that both patches of a ball are found."""
        return Claim(self.place, "both patches found", "%", "always", at_least(90))

    @property
    def taken(self) -> Claim:
        """Record of the number of times that an action is taken, which is not reported."""
        return Claim(self.place, "{action} taken")

    @property
    def negligible(self) -> Claim:
        """Claim about the number of actions until the reward is negligible."""
        return negligible_claim(self.place, 40, 60)

    @property
    def idle(self) -> Claim:
        """Claim that doing nothing becomes more frequent."""
        name = f"noop, last {_LAST} minus first {_FIRST} actions"
        return Claim(self.place, name, "actions", "grows", _GROWS)

    def all(self, series: ExplorationSeries) -> Iterator[Claim]:
        """Yield all claims about the exploration."""
        yield from map(self.rewarded, self.expected)
        if series is RED_BALL:
            yield from map(self.rewarded, ("reachtouch", "bimanualtouch"))
            yield from (self.inspected.named(action=action) for action in _INSPECTED)
            yield self.both
        yield from (self.taken, self.negligible, self.idle)


def claims_of(figure: str) -> CatalogClaims:
    place = f"Section 6.2.2, Figure {figure.removeprefix('fig-')}"
    return CatalogClaims(place, FIGURES[figure][1])


def _exactly(series: ExplorationSeries) -> Claim:
    """Return the claim that catalogs of an object have just the affordances of its icon."""
    name = f"{series.label}: catalogs with just these {len(_ICONS[series.name])} affordances"
    return Claim("Section 6.2.2, Figure 6.5", name, "%", "all", at_least(90))


CLAIMS: Claims = {
    **{figure: tuple(claims_of(figure).all(series)) for figure, (series, _) in FIGURES.items()},
    "fig-6.5": tuple(map(_exactly, (TABLE, BASKETBALL, RED_BALL))),
}


def run(settings: RunSettings, name: str) -> Result:
    """Explore, and count the rewarded actions."""
    with trial_runner(settings) as dexter:
        explored = gather(dexter, settings, name)
    if name == "fig-6.5":
        return _icons(explored)
    series, catalogs = explored[0]
    claims = claims_of(name)
    quantities = [
        *_shares(claims, catalogs),
        *(_marks(claims, catalogs) if series is RED_BALL else ()),
        *_counts(claims, catalogs),
        *_habituation(claims, catalogs, settings.seed),
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


def _shares(claims: CatalogClaims, catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    for name in claims.expected:
        yield share_of_actions(claims.rewarded(name), catalogs, name)


def _marks(claims: CatalogClaims, catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    """Yield the shares of inspections that find either of the two patches of a ball."""
    for name in ("reachtouch", "bimanualtouch"):
        yield share_of_actions(claims.rewarded(name), catalogs, name)
    names = dict.fromkeys(k for each in catalogs for k in each.affordances if "inspect" in k)
    # An inspection finds one patch or another, so that each share refers to all inspections.
    inspected = [sum(tally([each], name)[1] for name in names) for each in catalogs]
    for name in names:
        if name != "visualinspect":
            hits, _ = tallies(catalogs, name)
            yield clustered_percentage(claims.inspected.named(action=name), hits, inspected)
    both = sum(set(_INSPECTED) <= set(each.affordances) for each in catalogs)
    yield percentage(claims.both, both, len(catalogs))


def _counts(claims: CatalogClaims, catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    """Yield the mean number of times that each action was taken in a trial."""
    names = dict.fromkeys(a for each in catalogs for a in actions_of(each))
    for name in names:
        counts = np.array([float(actions_of(each).count(name)) for each in catalogs])
        interval = bootstrap_interval(counts.tolist()) if len(counts) > 1 else None
        yield Quantity(claims.taken.named(action=name), float(counts.mean()), interval)


def _habituation(
    claims: CatalogClaims, catalogs: Sequence[CatalogDocument], seed: int
) -> Iterator[Quantity]:
    yield negligible_reward(claims.negligible, catalogs, seed)
    # Each trial is its own control, so that differences of the objects' places cancel.
    more = np.array([_more_often(actions_of(each)) for each in catalogs])
    yield Quantity(
        claims.idle,
        float(more.mean()),
        bootstrap_interval(more.tolist()) if len(more) > 1 else None,
        chance_of_samples(_GROWS, more, mean, seed),
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
        quantities.append(percentage(_exactly(series), hits, len(catalogs)))
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

"""Three catalogs extended by PICKANDPLACE, and the resulting meta-catalogs (7.7 to 7.10)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.documents import CatalogDocument
from cbdsl.api.drawing import Layer
from cbdsl_reproduction.catalog_hierarchy import CatalogNode
from cbdsl_reproduction.chapter_6.action_counts import (
    action_bars,
    rewarded_claim,
    share_of_actions,
    tally,
)
from cbdsl_reproduction.chapter_6.habituation import actions_of, reward_chart, rewards
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.exploration_series import (
    BASKETBALL_PLACED,
    RED_BALL_PLACED,
    TABLE_PLACED,
    ExplorationSeries,
)
from cbdsl_reproduction.hierarchy import Hierarchy
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import ValueRegion, above, at_least, at_most, below, near
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

Floats = NDArray[np.float64]

_ACTION, _META = "pick_and_place", "fig-7.10"
# Numbers of actions before it is added and at the end, and of the trial phase after it is added.
_WINDOW, _DIP = 10, 20
_TOLERANCE = 0.02
# Least share of trials that habituate, %.
_MOST = 80
_PLACE = "Section 7.1.3, Figures 7.7 to 7.9"


class Grown(NamedTuple):
    """Report of the source about one object.

    Attributes:
        series: Series of explorations.
        report: Reward rate of PICKANDPLACE, in a few words.
        region: ValueRegion of the percentage of rewards.
        affords: True if the object can be transported.
    """

    series: ExplorationSeries
    report: str
    region: ValueRegion
    affords: bool

    def has(self) -> Claim:
        """Return the claim about the share of catalogs that have PICKANDPLACE."""
        report, region = (
            ("all", at_least(_MOST)) if self.affords else ("none", at_most(100 - _MOST))
        )
        name = f"{self.series.label}: catalogs that have {_ACTION}"
        return Claim("Section 7.1.3, Figure 7.10", name, "%", report, region)


#: By figure.
FIGURES: Mapping[str, Grown] = {
    "fig-7.7": Grown(TABLE_PLACED, "never", at_most(5), False),
    "fig-7.8": Grown(BASKETBALL_PLACED, "about 90 %, 22 tries", at_least(90), True),
    "fig-7.9": Grown(RED_BALL_PLACED, "about 90 %", at_least(90), True),
}

_SUCCEEDS = Claim(_PLACE, f"reward of the first {_ACTION} that succeeds", "", "large", above(0.0))
_RETURNS = Claim(
    _PLACE,
    f"mean reward, first {_WINDOW} actions with it minus last {_WINDOW} without",
    "",
    "returns",
    above(0.0),
)
_HABITUATES = Claim(
    _PLACE,
    f"trials whose model of {_ACTION} has habituated in the end",
    "%",
    "habituates within the 50",
    at_least(_MOST),
)
_DIPS = Claim(
    _PLACE,
    f"mean reward, first {_DIP} actions with it minus last {_WINDOW} without",
    "",
    "a small dip",
    below(0.0),
)
_RECOVERS = Claim(
    _PLACE,
    f"mean reward, last {_WINDOW} actions minus last {_WINDOW} without it",
    "",
    "the same",
    near(0.0, _TOLERANCE),
)
_TAKEN = Claim(_PLACE, f"{_ACTION} taken", "times a trial")


def _claims(grown: Grown) -> tuple[Claim, ...]:
    rewarded = rewarded_claim(_PLACE, _ACTION, grown.report, grown.region)
    more = (_SUCCEEDS, _RETURNS, _HABITUATES) if grown.affords else (_DIPS, _RECOVERS)
    return (rewarded, _TAKEN, *more)


CLAIMS: Claims = {
    **{name: _claims(grown) for name, grown in FIGURES.items()},
    _META: tuple(grown.has() for grown in FIGURES.values()),
}

_NOTES = (
    "The world of the figure of Chapter 6 with the same object, and with a pad where things can be "
    "placed; PICKANDPLACE joins after 100 actions. The pad is there from the beginning, so that "
    "only the action is new then, and VISUALINSPECT finds one channel more than in Chapter 6.",
    "Every action of every trial is carried out; the source drew 25 trials from the models of one.",
)


_META_NOTES = (
    "From the explorations of Figures 7.7 to 7.9. The place on the table is a pad of another color "
    "that lies there, where the source has the green table itself.",
)


def run(settings: RunSettings, name: str) -> Result:
    """Explore, add PICKANDPLACE, explore further, and measure its rewards."""
    with trial_runner(settings) as dexter:
        explored = gather(dexter, settings, name)
    if name == _META:
        return _meta(explored)
    grown, catalogs = FIGURES[name], explored[0]
    joined = joined_after(catalogs)
    measure = _returning if grown.affords else _in_vain
    quantities = (*_counts(grown, catalogs), *measure(catalogs, joined, settings.seed))
    label = grown.series.label
    pictures = (
        _first_trial(name, label, catalogs[0]),
        action_bars(name, label, catalogs),
        reward_chart(name, label, catalogs),
    )
    return Result(quantities, pictures, _NOTES)


def series_of(name: str) -> tuple[ExplorationSeries, ...]:
    """Return the series of explorations."""
    figures = FIGURES.values() if name == _META else (FIGURES[name],)
    return tuple(each.series for each in figures)


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> list[list[CatalogDocument]]:
    """Run all actions, and return the catalogs of the trials of each series."""
    for series in series_of(name):
        dexter.expect(len(dexter.numbers(series)) * dexter.actions(series))
    return [dexter.explore(series) for series in series_of(name)]


def joined_after(catalogs: Sequence[CatalogDocument]) -> int:
    """Return the number of actions of each trial before an action was added."""
    (after,) = {
        joined.after for each in catalogs if each.provenance for joined in each.provenance.joined
    }
    return after


def _counts(grown: Grown, catalogs: Sequence[CatalogDocument]) -> Iterator[Quantity]:
    yield share_of_actions(_claims(grown)[0], catalogs, _ACTION)
    own = [float(actions_of(each).count(_ACTION)) for each in catalogs]
    yield mean_of(_TAKEN, own)


def _returning(catalogs: Sequence[CatalogDocument], joined: int, seed: int) -> Iterator[Quantity]:
    """Yield quantities of a transportable object: reward returns, and habituates again."""
    reward = rewards(catalogs)
    firsts = [_first_reward(each) for each in catalogs]
    # Trials in which the action never succeeds have no such reward, and lower its share instead.
    known = [each for each in firsts if each is not None]
    yield mean_of(_SUCCEEDS, known, seed=seed)
    after = reward[:, joined : joined + _WINDOW].mean(axis=1)
    more = after - _before(reward, joined).mean(axis=1)
    yield mean_of(_RETURNS, more.tolist(), seed=seed)
    own = [
        each.affordances[_ACTION].habituation for each in catalogs if _ACTION in each.affordances
    ]
    # A catalog without the action has no model that could habituate, and counts as a failure.
    over = sum(each is not None and each.habituated for each in own)
    yield percentage(_HABITUATES, over, len(catalogs))


def _in_vain(catalogs: Sequence[CatalogDocument], joined: int, seed: int) -> Iterator[Quantity]:
    """Yield quantities of an unrewarded action: a dip, and then the same reward as before."""
    reward = rewards(catalogs)
    before = _before(reward, joined).mean(axis=1)
    # An action that earns nothing lowers the mean by its cost as long as it is tried.
    dip = reward[:, joined : joined + _DIP].mean(axis=1) - before
    yield mean_of(_DIPS, dip.tolist(), seed=seed)
    end = reward[:, -_WINDOW:].mean(axis=1) - before
    yield mean_of(_RECOVERS, end.tolist(), seed=seed)


def _meta(explored: Sequence[Sequence[CatalogDocument]]) -> Result:
    """Return the result of the extended catalogs, and of their meta-catalogs."""
    quantities, nodes = list[Quantity](), dict[str, CatalogNode]()
    for grown, catalogs in zip(FIGURES.values(), explored, strict=True):
        label = grown.series.label
        hits = sum(tally([each], _ACTION)[0] > 0 for each in catalogs)
        quantities.append(percentage(grown.has(), hits, len(catalogs)))
        nodes[label] = CatalogNode(label, _layers(catalogs))
    for grown, catalogs in zip(FIGURES.values(), explored, strict=True):
        if grown.affords:
            hits, tried = tally(catalogs, _ACTION)
            below = (grown.series.label, TABLE_PLACED.label)
            words = f"{grown.series.label} on the table"
            nodes[words] = CatalogNode(words, [Layer("placed", tried, hits)], below, _ACTION)
    title = "Two meta-catalogs (Figure 7.10)"
    return Result(tuple(quantities), (Hierarchy(_META, title, nodes),), _META_NOTES)


def _layers(catalogs: Sequence[CatalogDocument]) -> list[Layer]:
    """Return the affordances of an object by itself."""
    keys = dict.fromkeys(key for each in catalogs for key in each.affordances if key != _ACTION)
    counts = {key: tally(catalogs, key) for key in keys}
    return [Layer(key, tried, hits) for key, (hits, tried) in counts.items() if tried]


def _before(reward: Floats, joined: int) -> Floats:
    return reward[:, max(joined - _WINDOW, 0) : joined]


def _first_reward(catalog: CatalogDocument) -> float | None:
    """Return the reward of the first rewarded PICKANDPLACE."""
    steps = catalog.steps
    if steps is None:
        return None
    rows = zip(steps.action, steps.rewarded, steps.reward, strict=True)
    return next((r for action, rewarded, r in rows if rewarded and action == _ACTION), None)


def _first_trial(name: str, label: str, catalog: CatalogDocument) -> Chart:
    """Return a chart of the reward by action, with a separate line for PICKANDPLACE."""
    reward = rewards([catalog])[0]
    numbers = [float(k + 1) for k in range(len(reward))]
    own = [k for k, action in enumerate(actions_of(catalog)) if action == _ACTION]
    lines = [Line("all actions", tuple(numbers), tuple(reward.tolist()))]
    if own:
        x, y = tuple(numbers[k] for k in own), tuple(float(reward[k]) for k in own)
        lines.append(Line(_ACTION, x, y))
    title = f"{label}: reward in one trial"
    return Chart(f"{name}-trial", title, "action", "reward", tuple(lines))

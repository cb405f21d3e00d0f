"""Counts of the actions of explorations: how often each was taken, and rewarded."""

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.documents.catalog import CatalogDocument
from cbdsl.learning.action_outcome import NOOP
from cbdsl.reproduction.bar_chart import Bar, BarChart
from cbdsl.reproduction.claim import Claim
from cbdsl.reproduction.habituation import actions_of
from cbdsl.reproduction.percentage import clustered_percentage
from cbdsl.reproduction.quantity import Quantity


def tally(catalogs: Sequence[CatalogDocument], name: str) -> tuple[int, int]:
    """How often an action was rewarded, and taken, in all trials."""
    own = [each.affordances[name] for each in catalogs if name in each.affordances]
    return sum(each.rewarded for each in own), sum(each.tried for each in own)


def tallies(catalogs: Sequence[CatalogDocument], name: str) -> tuple[list[int], list[int]]:
    """How often an action was rewarded, and taken, in each trial."""
    each = [tally([catalog], name) for catalog in catalogs]
    return [hits for hits, _ in each], [tried for _, tried in each]


def share_of_actions(
    catalogs: Sequence[CatalogDocument],
    name: str,
    source: str = "no number",
    expected: Claim | None = None,
) -> Quantity:
    """The percentage of the actions of one name that were rewarded.

    Actions of one trial depend on each other: it has one object, in one place.
    """
    hits, tried = tallies(catalogs, name)
    return clustered_percentage(f"{name} rewarded", source, hits, tried, expected, of="actions")


def action_bars(name: str, label: str, catalogs: Sequence[CatalogDocument]) -> BarChart:
    """Bars of the actions of a mean trial, rewarded and not.

    Args:
        name: of the experiment.
        label: of the object.
        catalogs: one for each trial.
    """
    bars, trials = [], len(catalogs)
    for key in dict.fromkeys(k for each in catalogs for k in each.affordances):
        hits, tried = tally(catalogs, key)
        bars.append(Bar(key, hits / trials, (tried - hits) / trials))
    nothing = sum(actions_of(each).count(NOOP) for each in catalogs) / trials
    bars.append(Bar(NOOP, 0.0, nothing))
    title = f"{label}: actions of a trial"
    return BarChart(f"{name}-actions", title, tuple(bars), "rewarded", "not rewarded")

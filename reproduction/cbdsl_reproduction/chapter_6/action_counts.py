"""Counts of the actions of explorations, and of their rewards."""

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.api.documents import CatalogDocument
from cbdsl.api.learning import NOOP
from cbdsl_reproduction.bar_chart import Bar, BarChart
from cbdsl_reproduction.chapter_6.habituation import actions_of
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.percentage import clustered_percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import ValueRegion


def tally(catalogs: Sequence[CatalogDocument], name: str) -> tuple[int, int]:
    """Return the numbers of times that an action was rewarded and taken in all trials."""
    own = [each.affordances[name] for each in catalogs if name in each.affordances]
    return sum(each.rewarded for each in own), sum(each.tried for each in own)


def tallies(catalogs: Sequence[CatalogDocument], name: str) -> tuple[list[int], list[int]]:
    """Return the numbers of times that an action was rewarded and taken in each trial."""
    each = [tally([catalog], name) for catalog in catalogs]
    return [hits for hits, _ in each], [tried for _, tried in each]


def rewarded_claim(
    place: str,
    action: str = "{action}",
    report: str = "no number",
    region: ValueRegion | None = None,
) -> Claim:
    """Return the claim about the percentage of rewarded actions of one name, or of any."""
    return Claim(place, f"{action} rewarded", "%", report, region)


def share_of_actions(claim: Claim, catalogs: Sequence[CatalogDocument], name: str) -> Quantity:
    """Return the percentage of rewarded actions of one name.

    Actions of one trial are dependent, because it has one object in one place.
    """
    hits, tried = tallies(catalogs, name)
    return clustered_percentage(claim.named(action=name), hits, tried, of="actions")


def action_bars(name: str, label: str, catalogs: Sequence[CatalogDocument]) -> BarChart:
    """Return bars of the mean numbers of rewarded and unrewarded actions of a trial.

    Args:
        name: Name of the experiment.
        label: Label of the object.
        catalogs: Catalog of each trial.
    """
    bars, trials = [], len(catalogs)
    for key in dict.fromkeys(k for each in catalogs for k in each.affordances):
        hits, tried = tally(catalogs, key)
        bars.append(Bar(key, hits / trials, (tried - hits) / trials))
    # Doing nothing is no affordance of an object, so that only the sequence of actions counts it.
    nothing = sum(actions_of(each).count(NOOP) for each in catalogs) / trials
    bars.append(Bar(NOOP, 0.0, nothing))
    title = f"{label}: actions of a trial"
    return BarChart(f"{name}-actions", title, tuple(bars), "rewarded", "not rewarded")

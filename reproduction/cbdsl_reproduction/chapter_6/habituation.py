"""Habituation over the actions of explorations: rewards, and changes of models."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.documents import CatalogDocument, StepColumns
from cbdsl.api.learning import NOOP, ExplorationConstants
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim
from cbdsl_reproduction.estimate import chance_of_samples, median
from cbdsl_reproduction.interval import bootstrap_interval, median_interval
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import between

Floats = NDArray[np.float64]

# Reward is negligible if its mean over this number of actions stays below the cost of an action.
_WINDOW, _NEGLIGIBLE = 10, 0.05
_MOST_LINES = 4


def actions_of(catalog: CatalogDocument) -> tuple[str, ...]:
    """Return the actions of an exploration, in order."""
    return () if catalog.steps is None else catalog.steps.action


def rewards(catalogs: Sequence[CatalogDocument]) -> Floats:
    """Return the rewards by trial and action, shape (trials, actions)."""
    return np.array([each.steps.reward for each in catalogs if each.steps is not None])


def rewards_by_hindsight(catalogs: Sequence[CatalogDocument]) -> Floats:
    """Return the rewards relative to the largest change of the whole trial, as in the source.

    The largest change is known only at the end of a trial; no learner can use it.
    """
    return np.array([_by_hindsight(each.steps, cost_of(each)) for each in catalogs if each.steps])


def _by_hindsight(steps: StepColumns, cost: float) -> list[float]:
    # Without any change there is no largest one, and 1 leaves all zeros as they are.
    largest = max(steps.change, default=0.0) or 1.0
    return [
        0.0 if action == NOOP else change / largest - cost
        for action, change in zip(steps.action, steps.change, strict=True)
    ]


def cost_of(catalog: CatalogDocument) -> float:
    """Return the cost of an action; by default, the cost of the algorithm."""
    usual = ExplorationConstants().cost
    return float(catalog.provenance.constants.get("cost", usual)) if catalog.provenance else usual


def negligible_after(reward: Floats) -> float:
    """Return the number of actions after which a trial's reward is negligible, or infinity."""
    if len(reward) < _WINDOW:
        return math.inf
    # The reward of a single action depends on the drawn action. Its moving mean decides.
    means = np.convolve(reward, np.full(_WINDOW, 1 / _WINDOW), mode="valid")
    large = np.flatnonzero(means >= _NEGLIGIBLE)
    if not len(large):
        return 0.0
    # Window k, counted from 0, ends with action k + 10.
    last = int(large[-1]) + _WINDOW
    return float(last) if last < len(reward) else math.inf


def negligible_claim(place: str, low: int, high: int) -> Claim:
    """Return the claim that the reward is negligible after a range of actions."""
    name = "reward negligible after, median"
    return Claim(place, name, "actions", f"{low} to {high}", between(low, high))


def negligible_reward(claim: Claim, catalogs: Sequence[CatalogDocument], seed: int) -> Quantity:
    """Return the median number of actions after which the reward is negligible.

    Args:
        claim: Claim about that number.
        catalogs: Catalogs of the trials.
        seed: Seed of the resampling.
    """
    # A trial that never habituates counts as infinite,
    # which the median bears and the mean does not.
    after = np.array([negligible_after(row) for row in rewards(catalogs)])
    middle = float(np.median(after))
    assert claim.region is not None
    return Quantity(
        claim,
        middle,
        median_interval(after, seed) if len(after) > 1 and np.isfinite(middle) else None,
        chance_of_samples(claim.region, after[np.isfinite(after)], median, seed),
    )


def tries_until_habituated(catalog: CatalogDocument, name: str, share: float = 0.1) -> float:
    """Return the number of tries of an action until its model's change stays below a share.

    The share is of the largest change of the exploration.
    """
    steps = catalog.steps
    if steps is None:
        return math.nan
    bound = share * (max(steps.change, default=0.0) or 1.0)
    own = [c for a, c in zip(steps.action, steps.change, strict=True) if a == name]
    # Tries count from 1, so that try k + 2 follows the last large change, at index k.
    large = [index for index, change in enumerate(own) if change > bound]
    return float(large[-1] + 2) if large else 0.0


def reward_chart(name: str, label: str, catalogs: Sequence[CatalogDocument]) -> Chart:
    """Return a chart of the mean causal and hindsight rewards, with the causal one's interval."""
    causal, hindsight = rewards(catalogs), rewards_by_hindsight(catalogs)
    x = tuple(float(k + 1) for k in range(causal.shape[1]))
    ends = [bootstrap_interval(column) for column in causal.T] if len(causal) > 1 else []
    first = Line(
        "largest until then",
        x,
        tuple(causal.mean(axis=0).tolist()),
        tuple(low for low, _ in ends),
        tuple(high for _, high in ends),
    )
    second = Line("largest of the trial", x, tuple(hindsight.mean(axis=0).tolist()))
    return Chart(f"{name}-reward", f"{label}: reward", "action", "mean reward", (first, second))


def change_chart(name: str, label: str, catalogs: Sequence[CatalogDocument]) -> Chart | None:
    """Return a chart of the mean change of each model's variance, reward by reward."""
    keys = dict.fromkeys(key for each in catalogs for key in each.affordances)
    lines = []
    for key in keys:
        rows = [_changes(each, key) for each in catalogs]
        longest = max(map(len, rows))
        if longest > 1:
            # Trials have different numbers of rewards, so that later points are means over fewer
            # trials.
            y = [float(np.mean([r[k] for r in rows if len(r) > k])) for k in range(longest)]
            lines.append(Line(key, tuple(float(k + 1) for k in range(longest)), tuple(y)))
    if not lines:
        return None
    title = f"{label}: change of the models"
    own = tuple(lines[:_MOST_LINES])
    return Chart(f"{name}-change", title, "time that it was rewarded", "change, share", own)


def _changes(catalog: CatalogDocument, name: str) -> list[float]:
    """Return the changes of one model relative to the trial's largest, reward by reward."""
    steps = catalog.steps
    if steps is None:
        return []
    largest = max(steps.change, default=0.0) or 1.0
    rows = zip(steps.action, steps.rewarded, steps.change, strict=True)
    return [change / largest for action, rewarded, change in rows if rewarded and action == name]

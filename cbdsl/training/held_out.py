"""Predictions of a catalog on held-out scenes, compared with the rewards there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.documents.catalog import CatalogDocument
from cbdsl.program.catalog_models import is_known, models_of, predict
from cbdsl.training.exploration.action_runner import ActionRunner

# Number of probability bins of a reliability diagram.
_BINS = 5


class Prediction(NamedTuple):
    """Prediction of an action in a scene, and its outcome.

    Attributes:
        scene: Number of the scene.
        action: Name of the action.
        probability: Predicted probability of reward, given the features.
        base: Base rate of the action's rewards in the catalog, without the features.
        rewarded: True if the action was rewarded.
        known: True if the action was tried with such features; otherwise the probability is 0.5.
    """

    scene: int
    action: str
    probability: float
    base: float
    rewarded: bool
    known: bool = True


class Reliability(NamedTuple):
    """Predictions of about the same probability.

    Attributes:
        low, high: Bounds of the probability.
        number: Number of predictions.
        predicted: Mean predicted probability.
        rewarded: Share of rewarded predictions.
    """

    low: float
    high: float
    number: int
    predicted: float
    rewarded: float


def try_scenes(
    catalog: CatalogDocument,
    runner: ActionRunner,
    scenes: Sequence[int],
    seed: int,
    note: Callable[[Prediction], None] = lambda prediction: None,
) -> list[Prediction]:
    """Read the features of scenes, predict, and run one action in each scene, all in turn.

    Args:
        catalog: Catalog that predicts.
        runner: Runner of the catalog's actions.
        scenes: Numbers of the scenes; the number also selects the action.
        seed: Seed of all random numbers; no exploration with another seed has the same scenes.
        note: Listener that receives each prediction.
    """
    models, names = models_of(catalog), list(catalog.affordances)
    predictions = []
    for scene in scenes:
        own = int(np.random.SeedSequence([seed, 0, scene]).generate_state(1)[0])
        # The actions take turns, so that each is tried about equally often.
        name = names[scene % len(names)]
        ahead = runner.look(names, own).get(name, {})
        probability = predict(catalog.affordances[name], models[name], ahead)
        # Another turn of the experimenter would invalidate the features.
        outcome = runner.run(name, names, own, undisturbed=True)
        base = models[name].reward_probability
        known = is_known(catalog.affordances[name], models[name], ahead)
        predictions.append(Prediction(scene, name, probability, base, outcome.rewarded, known))
        note(predictions[-1])
    return predictions


def brier(predictions: Sequence[Prediction], *, base: bool = False) -> float:
    """Return the Brier score: mean square of probability, or base rate, minus outcome."""
    chosen = [each.base if base else each.probability for each in predictions]
    return float(
        np.mean([(p - each.rewarded) ** 2 for p, each in zip(chosen, predictions, strict=True)])
    )


def reliability(predictions: Sequence[Prediction]) -> list[Reliability]:
    """Return how often predictions come true, by probability; empty bins are left out."""
    rows = []
    for index in range(_BINS):
        low, high = index / _BINS, (index + 1) / _BINS
        own = [
            each
            for each in predictions
            # Only the last bin includes its upper bound.
            if low <= each.probability < high or (each.probability == 1.0 == high)
        ]
        if own:
            mean = float(np.mean([each.probability for each in own]))
            share = float(np.mean([each.rewarded for each in own]))
            rows.append(Reliability(low, high, len(own), mean, share))
    return rows

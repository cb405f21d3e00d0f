"""Predictions of a catalog on held-out scenes, beside what is rewarded there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.documents.catalog import CatalogDocument
from cbdsl.program.catalog_models import models_of, predict
from cbdsl.training.action_runner import ActionRunner

# Probabilities that are told apart in a reliability diagram.
_BINS = 5


class Prediction(NamedTuple):
    """Prediction of an action in a scene, and its outcome.

    Attributes:
        scene: its number.
        action: its name.
        probability: of reward, by what was seen.
        base: by how often the action was rewarded before, whatever was seen.
        rewarded: whether it was.
    """

    scene: int
    action: str
    probability: float
    base: float
    rewarded: bool


class Reliability(NamedTuple):
    """Predictions of about the same probability.

    Attributes:
        low, high: bounds of the probability.
        number: how many.
        predicted: their mean.
        rewarded: share of them that was rewarded.
    """

    low: float
    high: float
    number: int
    predicted: float
    rewarded: float


def try_scenes(
    catalog: CatalogDocument,
    runner: ActionRunner,
    scenes: int,
    seed: int,
    note: Callable[[Prediction], None] = lambda prediction: None,
) -> list[Prediction]:
    """Look at scenes, predict, and act: in each of them one action, all in turn.

    Args:
        catalog: predicts.
        runner: acts, with the actions of the catalog.
        scenes: how many.
        seed: of all chance; scenes are those of no exploration with another seed.
        note: is told each prediction.
    """
    models, names = models_of(catalog), list(catalog.affordances)
    predictions = []
    for scene in range(scenes):
        own = int(np.random.SeedSequence([seed, 0, scene]).generate_state(1)[0])
        name = names[scene % len(names)]
        ahead = runner.look(names, own).get(name, {})
        probability = predict(catalog.affordances[name], models[name], ahead)
        # Where the experimenter took another turn, what was seen would be over.
        outcome = runner.run(name, names, own, undisturbed=True)
        base = models[name].reward_probability
        predictions.append(Prediction(scene, name, probability, base, outcome.rewarded))
        note(predictions[-1])
    return predictions


def brier(predictions: Sequence[Prediction], *, base: bool = False) -> float:
    """Brier score: mean square of probability minus outcome; of the base rates instead."""
    chosen = [each.base if base else each.probability for each in predictions]
    return float(
        np.mean([(p - each.rewarded) ** 2 for p, each in zip(chosen, predictions, strict=True)])
    )


def reliability(predictions: Sequence[Prediction]) -> list[Reliability]:
    """How often what is predicted happens, by its probability; bins without any are left out."""
    rows = []
    for index in range(_BINS):
        low, high = index / _BINS, (index + 1) / _BINS
        own = [
            each
            for each in predictions
            if low <= each.probability < high or (each.probability == 1.0 == high)
        ]
        if own:
            mean = float(np.mean([each.probability for each in own]))
            share = float(np.mean([each.rewarded for each in own]))
            rows.append(Reliability(low, high, len(own), mean, share))
    return rows

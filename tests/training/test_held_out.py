"""Predictions of catalogs: Brier scores, reliability, and models read back from documents."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
import pytest

from cbdsl.documents.catalog import AffordanceSection, FeatureSection, SampleModel
from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.program.catalog_models import models_of, predict
from cbdsl.training.exploration.action_runner import ActionRunner
from cbdsl.training.held_out import Prediction, brier, reliability, try_scenes
from tests.training.drawn_catalog import TEN


def predictions(*pairs: tuple[float, bool]) -> list[Prediction]:
    return [Prediction(i, "touch", p, 0.5, rewarded) for i, (p, rewarded) in enumerate(pairs)]


def test_prophet_scores_nothing_and_a_coin_a_quarter() -> None:
    known = predictions((1.0, True), (0.0, False), (1.0, True))
    assert brier(known) == 0.0
    assert brier(known, base=True) == 0.25
    assert brier(predictions((0.8, False))) == pytest.approx(0.64)


def test_reliability_compares_predictions_with_observed_shares() -> None:
    rng = np.random.default_rng(3)
    fair = predictions(*((p, bool(rng.random() < p)) for p in rng.uniform(0, 1, 4000)))
    rows = reliability(fair)
    assert sum(row.number for row in rows) == 4000 and len(rows) == 5
    assert all(abs(row.predicted - row.rewarded) < 0.06 for row in rows)
    (bold,) = reliability(predictions(*[(0.95, False)] * 8, (1.0, False)))
    assert (bold.number, bold.rewarded) == (9, 0.0)


def affordance() -> AffordanceSection:
    near = {"mean": (0.5,), "covariance": ((0.0004,),)}
    far = {"mean": (0.9,), "covariance": ((0.0004,),)}
    return AffordanceSection(
        program="reachtouch",
        tried=60,
        rewarded=40,
        features={"x": FeatureSection(signal="count.red", unit="m", components=1)},
        with_reward=SampleModel(count=40, **near),
        without_reward=SampleModel(count=20, **far),
    )


def test_catalog_predicts_by_features_or_by_counts() -> None:
    own = affordance()
    (model,) = models_of(TEN.model_copy(update={"affordances": {"touch": own}})).values()
    assert predict(own, model, {"x": (0.5,)}) > 0.95
    assert predict(own, model, {"x": (0.9,)}) < 0.05
    assert predict(own, model, {"seen": ()}) == pytest.approx(41 / 62)
    assert predict(own, model, {"x": (0.5, 0.1)}) == pytest.approx(41 / 62)


class Scene:
    """Runner of actions with fixed features until the experimenter's next turn."""

    def __init__(self) -> None:
        self.seen = False

    def look(self, known: Sequence[str], seed: int) -> dict[str, dict[str, tuple[float, ...]]]:
        self.seen = True
        return {name: {"x": (0.5,)} for name in known}

    def run(
        self, name: str, known: Sequence[str], seed: int, *, undisturbed: bool = False
    ) -> ActionOutcome:
        return ActionOutcome(name, rewarded=self.seen and undisturbed)


def test_action_is_tried_in_the_scene_that_was_looked_at() -> None:
    catalog = TEN.model_copy(update={"affordances": {"touch": affordance()}})
    outcomes = try_scenes(catalog, cast("ActionRunner", Scene()), range(3), seed=1)
    assert [each.rewarded for each in outcomes] == [True] * 3
    assert all(each.probability > 0.95 > each.base for each in outcomes)

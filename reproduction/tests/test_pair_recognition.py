"""Recognition of two objects as a known pair."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.api.learning import AffordanceModel
from cbdsl_reproduction.judges.pair_recognition import recognise


def test_two_things_look_like_a_known_pair_or_like_none() -> None:
    models = {}
    for name, height in (("low", 0.05), ("high", 0.2)):
        model = AffordanceModel.fresh(np.full(3, 0.03))
        for shift in (-0.01, 0.0, 0.01, 0.005):
            model = model.updated(np.array([shift, -shift, height + shift]), rewarded=True)
        models[name] = model
    assert recognise(models, np.array([0.0, 0.0, 0.06])).pair == "low"
    assert recognise(models, np.array([0.0, 0.0, 0.19])).pair == "high"
    beside = recognise(models, np.array([0.2, 0.1, 0.0]))
    assert beside.pair is None and beside.distance > 4
    assert recognise({}, np.zeros(3)).pair is None
    assert recognise({n: m.over([2]) for n, m in models.items()}, np.array([0.19])).pair == "high"


def test_likeness_bound_excludes_one_in_a_thousand_own_samples() -> None:
    """Fisher's chi-squared law of squared distances: 10.828 for one component, 16.266 for three."""
    for size, bound in ((1, 10.828**0.5), (3, 16.266**0.5)):
        model = AffordanceModel.fresh(np.full(size, 0.03)).updated(np.zeros(size), rewarded=True)
        away = np.eye(size)[0] * 0.03
        unit = away / model.distance(away)
        for share, pair in ((0.999, "pair"), (1.001, None)):
            likeness = recognise({"pair": model}, share * bound * unit)
            assert likeness.pair == pair
            assert likeness.distance == pytest.approx(share * bound)


def test_pair_that_never_stayed_is_not_recognised() -> None:
    never = AffordanceModel.fresh(np.ones(1)).updated(np.zeros(1), rewarded=False)
    assert recognise({"never": never}, np.zeros(1)) == (None, np.inf)

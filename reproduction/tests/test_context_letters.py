"""Letters of the context encode motion, side and size, as far as they are seen."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest

from cbdsl_reproduction.learners.context_letters import LETTERS, context_letters


@pytest.mark.parametrize(
    ("features", "letters"),
    [
        ({"velocity.y": 0.0, "place.y": 0.6, "volume": 0.001}, "sls"),
        ({"velocity.y": 0.05, "place.y": -0.1, "volume": 0.001}, "lrs"),
        ({"velocity.y": -0.05, "place.y": 0.1, "volume": 0.02}, "rlL"),
        ({"place.y": 0.1, "volume": math.nan}, "?l?"),
        ({}, "???"),
    ],
)
def test_seen_objects_are_reported(features: Mapping[str, float], letters: str) -> None:
    assert context_letters(features) == letters
    assert len(letters) == LETTERS


@pytest.mark.parametrize(
    ("features", "letters"),
    [
        ({"velocity.y": 0.024, "place.y": 0.0, "volume": 0.0119}, "srs"),
        ({"velocity.y": 0.026, "place.y": 1e-9, "volume": 0.0121}, "llL"),
        ({"velocity.y": -0.026, "place.y": -1e-9, "volume": 0.012}, "rrs"),
    ],
)
def test_nearly_still_central_or_large_objects_are_distinguished(
    features: Mapping[str, float], letters: str
) -> None:
    assert context_letters(features) == letters

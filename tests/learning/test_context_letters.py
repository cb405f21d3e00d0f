"""Letters of the context tell motion, side and size, as far as they are seen."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest

from cbdsl.learning.context_letters import LETTERS, context_letters


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
def test_what_is_seen_is_told(features: Mapping[str, float], letters: str) -> None:
    assert context_letters(features) == letters
    assert len(letters) == LETTERS

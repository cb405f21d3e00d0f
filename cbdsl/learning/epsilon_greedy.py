"""Epsilon-greedy choice (Algorithm 1, line 9)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def choose(
    best: Sequence[str], actions: Sequence[str], epsilon: float, rng: np.random.Generator
) -> str:
    """One of the best actions, or with probability ``epsilon`` any action; evenly in both cases.

    Args:
        best: the actions of the largest value.
        actions: all actions, the best ones among them.
        epsilon: in [0, 1].
        rng: the only source of chance.
    """
    among = actions if rng.random() < epsilon else best
    return among[int(rng.integers(len(among)))]

"""Epsilon-greedy choice (Algorithm 1, line 9)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def choose(
    best: Sequence[str], actions: Sequence[str], epsilon: float, rng: np.random.Generator
) -> str:
    """Return a uniform choice among the best actions, or with probability ``epsilon`` among all.

    Args:
        best: Actions of the largest value.
        actions: All actions, including the best ones.
        epsilon: Probability of exploration, in [0, 1].
        rng: Random generator.
    """
    among = actions if rng.random() < epsilon else best
    return among[int(rng.integers(len(among)))]

"""Uniform sampling of a box without gaps."""

from __future__ import annotations

import numpy as np

from cbdsl.numeric.arrays import Floats


class UniformSampler:
    """Sampler of individually uniform and jointly even points.

    Independent draws revisit some places before they reach others, which makes a search by a camera
    with a narrow view long. An additive recurrence from a random start covers the box evenly, and
    every single draw is still uniformly distributed (Roberts 2018).

    Args:
        lower, upper: Corners of the box, shape (n,); infinite for a joint without limits, which is
            drawn over one turn.
        rng: Random number generator for the start.
    """

    def __init__(self, lower: Floats, upper: Floats, rng: np.random.Generator) -> None:
        lower, upper = (
            np.where(np.isinf(end), turn, end) for end, turn in ((lower, -np.pi), (upper, np.pi))
        )
        self._lower, self._span = lower, upper - lower
        # The generalised golden ratio: the root above 1 of x^(n + 1) = x + 1.
        ratio = 2.0
        # Forty steps of this fixed-point iteration reach the precision of a double for any n.
        for _ in range(40):
            ratio = (1 + ratio) ** (1 / (len(lower) + 1))
        self._step = ratio ** -np.arange(1.0, len(lower) + 1)
        self._point = rng.random(len(lower))

    def draw(self) -> Floats:
        """Return the next sample, shape (n,)."""
        self._point = (self._point + self._step) % 1.0
        sample: Floats = self._lower + self._span * self._point
        return sample

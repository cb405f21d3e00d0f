"""Uniform sampling of a box, without leaving gaps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class UniformSampler:
    """Draws that are uniform each, and even together.

    Independent draws revisit some places before they have been to others, which makes a search
    by a camera with a narrow view long. An additive recurrence from a random start covers the
    box evenly while every single draw stays uniformly distributed (Roberts 2018).

    Args:
        lower, upper: corners of the box, shape (n,); infinite for a joint that turns without
            limits, which is drawn over one turn.
        rng: gives the random start.
    """

    def __init__(self, lower: Floats, upper: Floats, rng: np.random.Generator) -> None:
        lower, upper = (
            np.where(np.isinf(end), turn, end) for end, turn in ((lower, -np.pi), (upper, np.pi))
        )
        self._lower, self._span = lower, upper - lower
        # The generalised golden ratio: the root above 1 of x^(n + 1) = x + 1.
        ratio = 2.0
        for _ in range(40):
            ratio = (1 + ratio) ** (1 / (len(lower) + 1))
        self._step = ratio ** -np.arange(1.0, len(lower) + 1)
        self._point = rng.random(len(lower))

    def draw(self) -> Floats:
        """The next sample, shape (n,)."""
        self._point = (self._point + self._step) % 1.0
        sample: Floats = self._lower + self._span * self._point
        return sample

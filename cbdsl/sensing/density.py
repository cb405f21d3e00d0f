"""Sampling from the densities of internal models (Section 3.2.3)."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.types.resource import GaussianSample, KernelSample, Source
from cbdsl.types.source_record import record_of


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


# A density may lie mostly outside the limits; then the nearest configuration is used.
_MOST_DRAWS = 1000


class Sampler(Protocol):
    """Source of successive samples."""

    def draw(self) -> Floats | None:
        """Return the next sample, SI units, shape (n,), or ``None`` while there is none."""
        ...


class DensitySampler:
    """Sampler of a Gaussian or kernel density within joint limits, mixed with uniform samples.

    Samples outside the limits are drawn again, so that the density within them keeps its shape.

    Args:
        source: Density.
        lower, upper: Joint limits, rad, or infinite for positions, shape (n,).
        rng: Random number generator.
    """

    def __init__(
        self,
        source: GaussianSample | KernelSample,
        lower: Floats,
        upper: Floats,
        rng: np.random.Generator,
    ) -> None:
        self._centres, self._deviation = np.array(source.centres), np.array(source.spread)
        self._lower, self._upper, self._rng = lower, upper, rng
        # The constructor draws a random start, so it runs only if uniform samples are needed.
        self._anywhere = UniformSampler(lower, upper, rng) if source.uniform else None
        self._uniform = source.uniform

    def draw(self) -> Floats:
        """Return the next sample, rad or m, shape (n,)."""
        if self._anywhere is not None and self._rng.random() < self._uniform:
            return self._anywhere.draw()
        for _ in range(_MOST_DRAWS):
            sample = self._any()
            if np.all((sample >= self._lower) & (sample <= self._upper)):
                return sample
        nearest: Floats = np.minimum(np.maximum(self._any(), self._lower), self._upper)
        return nearest

    def _any(self) -> Floats:
        """Return a sample of the density, inside the limits or not."""
        centre = self._centres[self._rng.integers(len(self._centres))]
        sample: Floats = self._rng.normal(centre, self._deviation)
        return sample


def joint_sampler(
    source: Source, lower: Floats, upper: Floats, rng: np.random.Generator
) -> Sampler:
    """Return a sampler of an internal model.

    Args:
        source: Uniform distribution or density.
        lower: Lower joint limits, rad, or infinite for positions, shape (n,).
        upper: Upper ones.
        rng: Random number generator.
    """
    if record_of(source).uniform:
        return UniformSampler(lower, upper, rng)
    density: Any = source
    return DensitySampler(density, lower, upper, rng)

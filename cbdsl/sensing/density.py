"""Sampling from the densities of internal models (Section 3.2.3)."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.uniform import UniformSampler
from cbdsl.types.resource import GaussianSample, KernelSample, Source
from cbdsl.types.source_record import record_of

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

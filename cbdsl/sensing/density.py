"""Draws from the densities of internal models (Section 3.2.3)."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.uniform import UniformSampler
from cbdsl.types.resource import GaussianSample, KernelSample

Floats = NDArray[np.float64]

# A density may lie outside the limits for the most part; then the nearest configuration serves.
_MOST_DRAWS = 1000


class Sampler(Protocol):
    """Gives one sample after another."""

    def draw(self) -> Floats | None:
        """The next sample, SI, shape (n,), or ``None`` while there is none."""
        ...


class DensitySampler:
    """Draws from a Gaussian or from a sum of kernels, within joint limits, or from all of them.

    What falls outside the limits is drawn again, so that the density within them keeps its shape.

    Args:
        source: the density.
        lower, upper: joint limits, rad, or infinite for positions, shape (n,).
        rng: gives the draws.
    """

    def __init__(
        self,
        source: GaussianSample | KernelSample,
        lower: Floats,
        upper: Floats,
        rng: np.random.Generator,
    ) -> None:
        if isinstance(source, GaussianSample):
            self._centres, self._deviation = np.array([source.mean]), np.array(source.deviation)
        else:
            self._centres, self._deviation = np.array(source.samples), np.array(source.bandwidth)
        self._lower, self._upper, self._rng = lower, upper, rng
        # Nothing is drawn that is not asked for.
        self._anywhere = UniformSampler(lower, upper, rng) if source.uniform else None
        self._uniform = source.uniform

    def draw(self) -> Floats:
        """The next sample, rad or m, shape (n,)."""
        if self._anywhere is not None and self._rng.random() < self._uniform:
            return self._anywhere.draw()
        for _ in range(_MOST_DRAWS):
            sample = self._any()
            if np.all((sample >= self._lower) & (sample <= self._upper)):
                return sample
        nearest: Floats = np.minimum(np.maximum(self._any(), self._lower), self._upper)
        return nearest

    def _any(self) -> Floats:
        """A draw from the density, inside the limits or not."""
        centre = self._centres[self._rng.integers(len(self._centres))]
        sample: Floats = self._rng.normal(centre, self._deviation)
        return sample

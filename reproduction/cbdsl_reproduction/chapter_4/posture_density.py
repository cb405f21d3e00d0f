"""Density over two joint angles, and its picture as SVG (Figures 4.4 c and 5.2 b)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl_reproduction.figure import VERMILION, drawing, shade

Floats = NDArray[np.float64]

# Size of a cell, rad; least shares of the maximum to be drawn, or a peak.
_CELL, _SEEN, _PEAK = 0.04, 0.02, 0.1


@dataclass(frozen=True)
class PostureDensity:
    """Sum of Gaussian kernels around postures.

    Attributes:
        name: Name of the file, without suffix.
        title: Title of the picture.
        postures: Angles of the two joints, rad, shape (n, 2).
        bandwidth: Standard deviation of the kernels, rad.
        limits: Limits of the two joints, by name, rad.
    """

    name: str
    title: str
    postures: Floats
    bandwidth: float
    limits: Mapping[str, tuple[float, float]]

    def data(self) -> dict[str, object]:
        """Return the postures, for scripts."""
        return {
            "joints": {joint: list(ends) for joint, ends in self.limits.items()},
            "bandwidth": self.bandwidth,
            "postures": self.postures.tolist(),
        }

    @property
    def axes(self) -> tuple[Floats, Floats]:
        """Centres of the cells along both joints, rad."""
        first, second = (np.arange(low + _CELL / 2, high, _CELL) for low, high in self._ends())
        return first, second

    def grid(self) -> Floats:
        """Return the density in each cell, with shape of the ``axes``; a kernel has height 1."""
        # A kernel is a product of one factor per joint, so that the sum over postures is a matrix
        # product.
        across, down = (
            np.exp(-0.5 * ((axis[:, None] - angles) / self.bandwidth) ** 2)
            for axis, angles in zip(self.axes, self.postures.T, strict=True)
        )
        total: Floats = across @ down.T
        return total

    def peaks(self) -> list[tuple[float, float]]:
        """Return the local maxima of at least a tenth of the highest density, rad."""
        if not len(self.postures):
            return []
        grid = self.grid()
        around = np.pad(grid, 1, constant_values=-np.inf)
        wide, tall = grid.shape
        shifts = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
        # Of two equally high cells, the first is the peak.
        above = [
            grid >= around[i : i + wide, j : j + tall]
            if (i, j) > (1, 1)
            else grid > around[i : i + wide, j : j + tall]
            for i, j in shifts
        ]
        tops = np.argwhere(np.all(above, axis=0) & (grid >= _PEAK * grid.max()))
        first, second = self.axes
        return [(float(first[i]), float(second[j])) for i, j in tops]

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        (left, right), (low, high) = self._ends()
        across, down = self.limits
        grid = self.grid()
        most = max(float(grid.max(initial=0.0)), np.finfo(float).tiny)
        shares = np.ma.masked_less(grid / most, _SEEN)
        with drawing(5.2, 4.4, self.title) as draft:
            axes = draft.axes
            shade(axes, "density", shares, (left, low), (_CELL, _CELL), 1.0, cmap="Blues")
            x, y = self.postures.T
            dots = axes.scatter(x, y, s=5, color=VERMILION, zorder=2)
            dots.set_gid("postures")
            axes.set(xlim=(left, right), ylim=(high, low), aspect="equal")
            axes.set_xlabel(f"{across}, rad", parse_math=False)
            axes.set_ylabel(f"{down}, rad; {len(self.postures)} postures", parse_math=False)
        return draft.svg

    def _ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        first, second = self.limits.values()
        return first, second

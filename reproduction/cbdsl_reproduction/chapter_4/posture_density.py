"""Density over two joint angles, and its picture as SVG (Figures 4.4 c and 5.2 b)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Sizes of the picture, px; size of a cell, rad; least shares of the maximum to be drawn, or a peak.
_SIDE, _GAP, _TOP, _CELL, _SEEN, _PEAK = 420, 50, 44, 0.04, 0.02, 0.1


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
        scale = _SIDE / (right - left)
        width, height = _SIDE + 2 * _GAP, _TOP + (high - low) * scale + _GAP
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height:.0f}" '
            'font-family="sans-serif" font-size="11">',
            f'<rect width="{width}" height="{height:.0f}" fill="#ffffff"/>',
            f'<text x="{_GAP}" y="20" font-size="12" font-weight="bold">'
            f"{escape(self.title)}</text>",
            *self._cells(scale),
            *self._frame(scale),
        ]
        return "\n".join([*parts, "</svg>", ""])

    def _ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        first, second = self.limits.values()
        return first, second

    def _cells(self, scale: float) -> Iterator[str]:
        grid, side = self.grid(), _CELL * scale
        most = max(float(grid.max(initial=0.0)), np.finfo(float).tiny)
        for column, row in np.argwhere(grid >= _SEEN * most):
            yield (
                f'<rect x="{_GAP + column * side:.1f}" y="{_TOP + row * side:.1f}" '
                f'width="{side:.2f}" height="{side:.2f}" fill="#0072b2" '
                f'fill-opacity="{grid[column, row] / most:.2f}"/>'
            )

    def _frame(self, scale: float) -> Iterator[str]:
        (left, right), (low, high) = self._ends()
        tall, (across, down) = (high - low) * scale, self.limits
        below = _TOP + tall + 14
        yield (
            f'<rect x="{_GAP}" y="{_TOP}" width="{_SIDE}" height="{tall:.1f}" fill="none" '
            'stroke="#888888"/>'
        )
        for pan, tilt in self.postures:
            x, y = _GAP + (pan - left) * scale, _TOP + (tilt - low) * scale
            yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="1.5" fill="#d55e00"/>'
        for angle, x in ((left, _GAP), (0.0, _GAP - left * scale), (right, _GAP + _SIDE)):
            yield f'<text x="{x:.1f}" y="{below:.1f}" text-anchor="middle">{angle:.3g}</text>'
        for angle, y in ((low, float(_TOP)), (0.0, _TOP - low * scale), (high, _TOP + tall)):
            yield f'<text x="{_GAP - 4}" y="{y + 4:.1f}" text-anchor="end">{angle:.3g}</text>'
        yield (
            f'<text x="{_GAP}" y="{_TOP + tall + 34:.1f}">{escape(across)} to the right, '
            f"{escape(down)} downwards, rad; {len(self.postures)} postures</text>"
        )

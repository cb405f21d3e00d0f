"""Cross-sections of a density over positions, from above and from the side (Figure 5.6)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Scale, px/m; gaps around panels, px; size of a cell and margin around the content, m.
_SCALE, _GAP, _TOP, _CELL, _MARGIN = 300, 40, 60, 0.02, 0.1
_VIEWS = (("(a) from above", 0, 1), ("(b) from the side", 0, 2))
_COLORS = ("#0072b2", "#d55e00", "#cc79a7")


@dataclass(frozen=True)
class CrossSections:
    """Picture of a sum of kernels around positions, summed along z and along y.

    Attributes:
        name: Name of the file, without suffix.
        title: Title of the picture.
        samples: Positions by label, m, world frame, shape (k, 3).
        bandwidth: Standard deviation of the kernels, m.
        outline: Lower and upper corner of the table, m, shape (2, 3).
    """

    name: str
    title: str
    samples: Mapping[str, Floats]
    bandwidth: float
    outline: Floats

    def data(self) -> dict[str, object]:
        """Return the positions, for scripts."""
        return {
            "bandwidth": self.bandwidth,
            "table": self.outline.tolist(),
            "samples": {name: each.tolist() for name, each in self.samples.items()},
        }

    @property
    def positions(self) -> Floats:
        """All positions, m, shape (n, 3)."""
        return np.concatenate([np.empty((0, 3)), *self.samples.values()])

    def density(self, across: int, up: int, at: Floats) -> Floats:
        """Return the density along two axes; a single kernel has height 1.

        Args:
            across, up: Indices of the axes.
            at: Positions at which to evaluate the density, m, shape (k, 2).

        Returns:
            Densities, shape (k,).
        """
        apart = at[:, None] - self.positions[None, :, [across, up]]
        total: Floats = np.exp(-0.5 * (apart**2).sum(axis=2) / self.bandwidth**2).sum(axis=1)
        return total

    def peak(self) -> Floats:
        """Return the sample with the highest density from above, m, shape (2,)."""
        level = self.positions[:, :2]
        highest: Floats = level[int(np.argmax(self.density(0, 1, level)))]
        return highest

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        lower, upper = self._corners()
        left, panels = float(_GAP), list[str]()
        for title, across, up in _VIEWS:
            frame = _Section(left, lower[[across, up]], upper[[across, up]])
            panels.extend(self._panel(frame, title, across, up))
            left += frame.width + _GAP
        heights = [upper[up] - lower[up] for _, _, up in _VIEWS]
        height = _TOP + max(heights) * _SCALE + 2 * _GAP
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left:.0f} {height:.0f}" '
            'font-family="sans-serif" font-size="11">'
            f'<rect width="{left:.0f}" height="{height:.0f}" fill="#ffffff"/>'
            f'<text x="{_GAP}" y="20" font-size="12" font-weight="bold">'
            f"{escape(self.title)}</text>{''.join(panels)}{''.join(self._legend(height))}</svg>"
        )

    def _corners(self) -> tuple[Floats, Floats]:
        shown = np.concatenate([self.positions, self.outline])
        return shown.min(axis=0) - _MARGIN, shown.max(axis=0) + _MARGIN

    def _panel(self, frame: _Section, title: str, across: int, up: int) -> Iterator[str]:
        axes = "xyz"
        yield f'<text x="{frame.left:.1f}" y="{_TOP - 8}">{title}: {axes[across]} to the right, '
        yield f"{axes[up]} upwards, m</text>"
        yield from self._cells(frame, across, up)
        low, high = self.outline[:, [across, up]]
        yield frame.box(low, high, 'fill="none" stroke="#009e73" stroke-width="2"')
        for color, own in zip(_COLORS, self.samples.values(), strict=False):
            for place in own[:, [across, up]]:
                x, y = frame.at(place)
                yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2" fill="{color}"/>'
        yield frame.box(frame.lower, frame.upper, 'fill="none" stroke="#888888"')
        yield from frame.labels()

    def _cells(self, frame: _Section, across: int, up: int) -> Iterator[str]:
        grid = [
            np.arange(low, high, _CELL) for low, high in zip(frame.lower, frame.upper, strict=True)
        ]
        corners = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 2)
        density = self.density(across, up, corners + _CELL / 2)
        most = max(float(density.max(initial=0.0)), np.finfo(float).tiny)
        for corner, value in zip(corners, density / most, strict=True):
            if value >= 0.02:
                upper = np.minimum(corner + _CELL, frame.upper)
                yield frame.box(corner, upper, f'fill="#000000" fill-opacity="{0.6 * value:.2f}"')

    def _legend(self, height: float) -> Iterator[str]:
        x = float(_GAP)
        for color, (name, own) in zip(_COLORS, self.samples.items(), strict=False):
            yield f'<circle cx="{x:.0f}" cy="{height - 14:.0f}" r="4" fill="{color}"/>'
            yield f'<text x="{x + 8:.0f}" y="{height - 10:.0f}">{escape(name)}: {len(own)}</text>'
            x += 130
        yield f'<text x="{x:.0f}" y="{height - 10:.0f}" fill="#009e73">table</text>'


@dataclass(frozen=True)
class _Section:
    """Part of a plane in the picture: its left edge, px, and its corners, m, shape (2,)."""

    left: float
    lower: Floats
    upper: Floats

    @property
    def width(self) -> float:
        return float(self.upper[0] - self.lower[0]) * _SCALE

    def at(self, place: Floats) -> tuple[float, float]:
        """Return the pixel coordinates of a position, px."""
        x, y = (place[0] - self.lower[0]) * _SCALE, (self.upper[1] - place[1]) * _SCALE
        return self.left + float(x), _TOP + float(y)

    def box(self, low: Floats, high: Floats, style: str) -> str:
        x, y = self.at(np.array((low[0], high[1])))
        wide, tall = (high - low) * _SCALE
        return f'<rect x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{tall:.1f}" {style}/>'

    def labels(self) -> Iterator[str]:
        """Yield the labels of the ends of both axes, rounded to cm."""
        (x, y), (right, top) = self.at(self.lower), self.at(self.upper)
        for label, at in ((self.lower[0], x), (self.upper[0], right)):
            yield f'<text x="{at:.1f}" y="{y + 12:.1f}" text-anchor="middle">{label:.2f}</text>'
        for label, at in ((self.lower[1], y), (self.upper[1], top)):
            yield f'<text x="{x - 3:.1f}" y="{at:.1f}" text-anchor="end">{label:.2f}</text>'

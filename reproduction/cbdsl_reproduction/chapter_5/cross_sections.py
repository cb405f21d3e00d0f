"""Cross-sections of a density over positions, from above and from the side (Figure 5.6)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbdsl_reproduction.figure import BLUE, GREEN, PURPLE, VERMILION, drawing, shade

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

# Size of a cell and margin around the content, m; least share of the maximum to be drawn.
_CELL, _MARGIN, _SEEN = 0.02, 0.1, 0.02
_VIEWS = (("(a) from above", 0, 1), ("(b) from the side", 0, 2))
_COLORS = (BLUE, VERMILION, PURPLE)


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
        # The integral of an isotropic Gaussian along one axis is a Gaussian over the
        # other two axes. The third coordinate is therefore left out, not summed.
        apart = at[:, None] - self.positions[None, :, [across, up]]
        total: Floats = np.exp(-0.5 * (apart**2).sum(axis=2) / self.bandwidth**2).sum(axis=1)
        return total

    def peak(self) -> Floats:
        """Return the sample with the highest density from above, m, shape (2,)."""
        # Samples are the only candidates, so that the
        # result is within about a bandwidth of the maximum.
        level = self.positions[:, :2]
        highest: Floats = level[int(np.argmax(self.density(0, 1, level)))]
        return highest

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        lower, upper = self._corners()
        with drawing(7.2, 3.8, self.title, columns=len(_VIEWS)) as draft:
            for axes, (title, across, up) in zip(draft.panels, _VIEWS, strict=True):
                axes.set_title(title, weight="normal")
                self._draw(axes, lower[[across, up]], upper[[across, up]], across, up)
            draft.figure.legend(
                *draft.axes.get_legend_handles_labels(), loc="outside lower left", ncols=4
            )
        return draft.svg

    def _corners(self) -> tuple[Floats, Floats]:
        shown = np.concatenate([self.positions, self.outline])
        return shown.min(axis=0) - _MARGIN, shown.max(axis=0) + _MARGIN

    def _draw(self, axes: Axes, lower: Floats, upper: Floats, across: int, up: int) -> None:
        from matplotlib.patches import Rectangle

        grid = [np.arange(low, high, _CELL) for low, high in zip(lower, upper, strict=True)]
        places = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1) + _CELL / 2
        density = self.density(across, up, places.reshape(-1, 2)).reshape(places.shape[:2])
        most = max(float(density.max(initial=0.0)), np.finfo(float).tiny)
        shares = np.ma.masked_less(density / most, _SEEN)
        # A grey of half the depth leaves the marks visible.
        shade(axes, "density", shares, lower.tolist(), (_CELL, _CELL), 2.0, cmap="Greys")
        low, high = self.outline[:, [across, up]]
        table = Rectangle((low[0], low[1]), *(high - low), fill=False, edgecolor=GREEN)
        table.set_label("outline of the table")
        axes.add_patch(table)
        for color, (name, own) in zip(_COLORS, self.samples.items(), strict=False):
            x, y = own[:, [across, up]].T
            dots = axes.scatter(x, y, s=9, color=color, label=f"{name}: {len(own)}", zorder=2)
            dots.set_gid(f"samples {name}")
        axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), aspect="equal")
        axes.set_xlabel(f"{'xyz'[across]}, m")
        axes.set_ylabel(f"{'xyz'[up]}, m")

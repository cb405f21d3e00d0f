"""Posture panels: histograms of two joint angles side by side, one for each channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbdsl_reproduction.figure import drawing, shade

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

_COLUMNS, _CELLS = 5, 18


@dataclass(frozen=True)
class PosturePanels:
    """Picture of histograms of postures of two joints.

    Attributes:
        name: Name of the file, without suffix.
        title: Title of the picture.
        panels: Angles by the name of the panel, rad, shape (samples, 2).
        limits: Limits of the two joints, by name, rad.
    """

    name: str
    title: str
    panels: Mapping[str, Floats]
    limits: Mapping[str, tuple[float, float]]

    def data(self) -> dict[str, object]:
        """Return the postures, for scripts."""
        return {
            "joints": {joint: list(ends) for joint, ends in self.limits.items()},
            "panels": {name: postures.tolist() for name, postures in self.panels.items()},
        }

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        rows = -(-len(self.panels) // _COLUMNS)
        first, second = self.limits
        with drawing(7.2, 0.6 + 1.5 * rows, self.title, rows=rows, columns=_COLUMNS) as draft:
            for axes in draft.panels[len(self.panels) :]:
                axes.set_axis_off()
            for axes, (name, postures) in zip(draft.panels, self.panels.items(), strict=False):
                self._draw(axes, name, postures)
            words = f"{first} to the right, {second} downwards, over all of their limits"
            draft.figure.supxlabel(words, size="medium").set_parse_math(False)
        return draft.svg

    def _draw(self, axes: Axes, name: str, postures: Floats) -> None:
        counted = f"{name}: {len(postures)}" if len(postures) else f"{name}: nothing"
        axes.set_title(counted, parse_math=False, weight="normal")
        (left, right), (low, high) = self.limits.values()
        axes.set(xticks=(), yticks=())
        axes.spines[["top", "right"]].set_visible(True)
        if not len(postures):
            return
        x, y = postures.T
        counts, _, _ = np.histogram2d(x, y, _CELLS, list(self.limits.values()))
        # The lightest cell stays visible.
        cells = np.ma.masked_equal(counts, 0) + counts.max() / 3
        size = (right - left) / _CELLS, (high - low) / _CELLS
        darkest = 4 * counts.max() / 3
        shade(axes, f"cells {name}", cells, (left, low), size, darkest, cmap="Blues")
        axes.set(xlim=(left, right), ylim=(high, low), aspect="auto")

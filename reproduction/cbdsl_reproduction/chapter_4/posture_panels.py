"""Posture panels: histograms of two joint angles side by side, one for each channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_COLUMNS, _SIDE, _GAP, _TOP, _CELLS = 5, 130, 14, 44, 18


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
        width = _COLUMNS * (_SIDE + _GAP) + _GAP
        height = _TOP + rows * (_SIDE + 2 * _GAP + 8) + _GAP
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            'font-family="sans-serif" font-size="11">',
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
            f'<text x="{_GAP}" y="20" font-size="12" font-weight="bold">'
            f"{escape(self.title)}</text>",
        ]
        for index, (name, postures) in enumerate(self.panels.items()):
            left = _GAP + index % _COLUMNS * (_SIDE + _GAP)
            top = _TOP + index // _COLUMNS * (_SIDE + 2 * _GAP + 8)
            parts.extend(self._panel(name, postures, left, top))
        first, second = self.limits
        parts.append(
            f'<text x="{_GAP}" y="{height - 4}">{escape(first)} to the right, '
            f"{escape(second)} downwards, over all of their limits</text></svg>"
        )
        return "".join(parts)

    def _panel(self, name: str, postures: Floats, left: int, top: int) -> Iterator[str]:
        counted = f"{name}: {len(postures)}" if len(postures) else f"{name}: nothing"
        yield f'<text x="{left}" y="{top - 4}">{escape(counted)}</text>'
        yield (
            f'<rect x="{left}" y="{top}" width="{_SIDE}" height="{_SIDE}" fill="none" '
            'stroke="#888888"/>'
        )
        if not len(postures):
            return
        counts, _, _ = np.histogram2d(
            postures[:, 0], postures[:, 1], _CELLS, list(self.limits.values())
        )
        cell = _SIDE / _CELLS
        for column, row in np.argwhere(counts > 0):
            shade = 0.25 + 0.75 * counts[column, row] / counts.max()
            yield (
                f'<rect x="{left + column * cell:.1f}" y="{top + row * cell:.1f}" '
                f'width="{cell:.1f}" height="{cell:.1f}" fill="#0072b2" '
                f'fill-opacity="{shade:.2f}"/>'
            )

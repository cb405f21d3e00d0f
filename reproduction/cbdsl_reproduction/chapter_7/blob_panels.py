"""Blobs of objects in a camera's image, one panel for each moment (Figures 7.15 and 7.16)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

# Sizes of panels, px; half-widths of the shown field of view, horizontally and vertically, rad.
_WIDTH, _HEIGHT, _GAP, _TOP = 240, 180, 16, 58
_ACROSS, _UP = 0.365, 0.28
_LONGEST = 5

Blobs = Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class BlobPanels:
    """Picture of ellipses with the second moments of the regions.

    Attributes:
        name: Name of the file, without suffix.
        title: Title of the picture.
        panels: Blobs of each object by the description of the moment: heading and semi-axes, two
            angles each, and the direction of the longer axis if it has one, rad.
        colors: Colours of the objects.
    """

    name: str
    title: str
    panels: Mapping[str, Blobs]
    colors: Mapping[str, str]

    def data(self) -> dict[str, object]:
        """Return the blobs, for scripts."""
        return {
            moment: {thing: list(blob) for thing, blob in blobs.items()}
            for moment, blobs in self.panels.items()
        }

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        width = len(self.panels) * (_WIDTH + _GAP) + _GAP
        height = _TOP + _HEIGHT + 40
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            'font-family="sans-serif" font-size="12">',
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
            f'<text x="{_GAP}" y="20" font-weight="bold">{escape(self.title)}</text>',
        ]
        for place, (moment, blobs) in enumerate(self.panels.items()):
            parts += self._panel(_GAP + place * (_WIDTH + _GAP), moment, blobs)
        return "\n".join([*parts, *self._legend(height - 14), "</svg>", ""])

    def _panel(self, left: int, moment: str, blobs: Blobs) -> Iterator[str]:
        yield f'<text x="{left}" y="{_TOP - 8}">{escape(moment)}</text>'
        yield (
            f'<svg x="{left}" y="{_TOP}" width="{_WIDTH}" height="{_HEIGHT}" '
            f'viewBox="0 0 {_WIDTH} {_HEIGHT}">'
        )
        yield f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#f4f4f4" stroke="#888888"/>'
        for thing, blob in blobs.items():
            yield _ellipse(blob, self.colors[thing])
        yield "</svg>"

    def _legend(self, y: int) -> Iterator[str]:
        for place, (thing, color) in enumerate(self.colors.items()):
            x = _GAP + 130 * place
            yield f'<circle cx="{x + 6}" cy="{y - 4}" r="6" fill="{color}"/>'
            yield f'<text x="{x + 18}" y="{y}">{escape(thing.replace("_", " "))}</text>'


def _ellipse(blob: tuple[float, ...], color: str) -> str:
    azimuth, elevation, longer, shorter = blob[:4]
    scale = _WIDTH / (2 * _ACROSS)
    x, y = (_ACROSS - azimuth) * scale, (_UP - elevation) * scale
    # Azimuth increases to the left and elevation upwards; both signs cancel out.
    turn = math.degrees(blob[4]) if len(blob) == _LONGEST else 0.0
    return (
        f'<ellipse rx="{longer * scale:.1f}" ry="{shorter * scale:.1f}" fill="{color}" '
        f'fill-opacity="0.75" transform="translate({x:.1f} {y:.1f}) rotate({turn:.1f})"/>'
    )

"""Catalog icon: affordances stacked on their object (Figure 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

#: Dimensions of an icon, px.
WIDTH = 300
_HEIGHT, _GAP, _MARGIN = 34, 4, 12
_ORANGE, _EMPTY, _INK, _OBJECT = "#e69f00", "#fbeed2", "#222222", "#dddddd"


class Layer(NamedTuple):
    """One affordance of an icon.

    Attributes:
        name: Name of the action.
        tried: Number of trials.
        rewarded: Number of rewarded trials.
    """

    name: str
    tried: int
    rewarded: int


def catalog_icon(name: str, feature: str, layers: Sequence[Layer]) -> str:
    """Return an SVG of a catalog with one layer per rewarded affordance, the surest at the bottom.

    The filled share of a layer is the share of rewarded trials of its action.
    """
    height, parts = icon_parts(f"{name} ({feature})", layers)
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
            f'font-family="sans-serif" font-size="13">',
            f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
            *parts,
            "</svg>",
            "",
        ]
    )


def icon_parts(words: str, layers: Sequence[Layer]) -> tuple[int, list[str]]:
    """Return the height of an icon, px, and its elements, for a drawing with several icons.

    Args:
        words: Label on the object.
        layers: Affordances, as for ``catalog_icon``.
    """
    # An action without any reward is not afforded. All others were tried, so that no division below
    # is by zero.
    afforded = [layer for layer in layers if layer.rewarded]
    # Rows are drawn downwards. Ascending shares put the surest affordance directly on the object.
    ordered = sorted(afforded, key=lambda layer: layer.rewarded / layer.tried)
    height = 2 * _MARGIN + (len(ordered) + 1) * (_HEIGHT + _GAP)
    parts: list[str] = []
    for row, layer in enumerate(ordered):
        parts += _layer(layer, _MARGIN + row * (_HEIGHT + _GAP))
    y = _MARGIN + len(ordered) * (_HEIGHT + _GAP)
    width = WIDTH - 2 * _MARGIN
    parts += [
        f'<rect x="{_MARGIN}" y="{y}" width="{width}" height="{_HEIGHT}" rx="5" fill="{_OBJECT}"/>',
        _text(WIDTH / 2, y, words, "middle", "bold"),
    ]
    return height, parts


def _layer(layer: Layer, y: float) -> list[str]:
    width = WIDTH - 2 * _MARGIN
    filled = round(width * layer.rewarded / layer.tried, 1)
    box = f'x="{_MARGIN}" y="{y}" height="{_HEIGHT}" rx="5"'
    return [
        f'<rect {box} width="{width}" fill="{_EMPTY}" stroke="{_ORANGE}"/>',
        f'<rect {box} width="{filled}" fill="{_ORANGE}"/>',
        _text(_MARGIN + 10, y, layer.name),
        _text(WIDTH - _MARGIN - 10, y, f"{layer.rewarded} of {layer.tried}", "end"),
    ]


def _text(x: float, y: float, text: str, anchor: str = "start", weight: str = "normal") -> str:
    return (
        f'<text x="{x:g}" y="{y + _HEIGHT / 2 + 5:g}" text-anchor="{anchor}" '
        f'font-weight="{weight}" fill="{_INK}">{escape(text)}</text>'
    )

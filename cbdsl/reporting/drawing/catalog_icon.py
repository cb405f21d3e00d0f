"""Catalog icon: affordances stacked on their object (Figure 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

# Dimensions of an icon, px.
_WIDTH, _HEIGHT, _GAP, _MARGIN = 300, 34, 4, 12
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
    # An action without any reward is not afforded. All others were tried, so that no division below
    # is by zero.
    afforded = [layer for layer in layers if layer.rewarded]
    # Rows are drawn downwards. Ascending shares put the surest affordance directly on the object.
    ordered = sorted(afforded, key=lambda layer: layer.rewarded / layer.tried)
    y = _MARGIN + len(ordered) * (_HEIGHT + _GAP)
    height = y + _HEIGHT + _GAP + _MARGIN
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" '
        'font-family="sans-serif" font-size="13">',
        f'<rect width="{_WIDTH}" height="{height}" fill="#ffffff"/>',
    ]
    for row, layer in enumerate(ordered):
        parts += _layer(layer, _MARGIN + row * (_HEIGHT + _GAP))
    width = _WIDTH - 2 * _MARGIN
    parts += [
        f'<rect x="{_MARGIN}" y="{y}" width="{width}" height="{_HEIGHT}" rx="5" fill="{_OBJECT}"/>',
        _text(_WIDTH / 2, y, f"{name} ({feature})", "middle", "bold"),
    ]
    return "\n".join([*parts, "</svg>", ""])


def _layer(layer: Layer, y: float) -> list[str]:
    width = _WIDTH - 2 * _MARGIN
    filled = round(width * layer.rewarded / layer.tried, 1)
    box = f'x="{_MARGIN}" y="{y}" height="{_HEIGHT}" rx="5"'
    return [
        f'<rect {box} width="{width}" fill="{_EMPTY}" stroke="{_ORANGE}"/>',
        f'<rect {box} width="{filled}" fill="{_ORANGE}"/>',
        _text(_MARGIN + 10, y, layer.name),
        _text(_WIDTH - _MARGIN - 10, y, f"{layer.rewarded} of {layer.tried}", "end"),
    ]


def _text(x: float, y: float, text: str, anchor: str = "start", weight: str = "normal") -> str:
    return (
        f'<text x="{x:g}" y="{y + _HEIGHT / 2 + 5:g}" text-anchor="{anchor}" '
        f'font-weight="{weight}" fill="{_INK}">{escape(text)}</text>'
    )

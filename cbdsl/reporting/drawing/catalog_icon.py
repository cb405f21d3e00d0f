"""Catalog icon: affordances stacked upon the object that has them (Figure 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

#: Of an icon, px.
WIDTH = 300
_HEIGHT, _GAP, _MARGIN = 34, 4, 12
_ORANGE, _EMPTY, _INK, _OBJECT = "#e69f00", "#fbeed2", "#222222", "#dddddd"


class Layer(NamedTuple):
    """One affordance of an icon.

    Attributes:
        name: of the action.
        tried: how often it was taken.
        rewarded: how often it was rewarded.
    """

    name: str
    tried: int
    rewarded: int


def catalog_icon(name: str, feature: str, layers: Sequence[Layer]) -> str:
    """SVG of a catalog: one layer per affordance that was ever rewarded, the surest at the bottom.

    How much of a layer is filled says how often its action was rewarded.
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
    """Height of an icon, px, and its elements, for a drawing that has several.

    Args:
        words: on the object.
        layers: as ``catalog_icon`` has them.
    """
    afforded = [layer for layer in layers if layer.rewarded]
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

"""Hierarchy of catalogs: icons of objects, below icons of their combinations (Fig 7.10, 7.17)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

from cbdsl.api.drawing import ICON_WIDTH, Layer, icon_parts

_GAP, _RISE, _MARGIN, _EDGE, _LINE, _INK = 24, 56, 14, 12, "#888888", "#222222"


class CatalogNode(NamedTuple):
    """One catalog of a hierarchy.

    Attributes:
        words: Label of the object.
        layers: Affordances of the object; unrewarded ones are not drawn.
        below: Names of the catalogs that it joins.
        action: Action that joins them.
    """

    words: str
    layers: Sequence[Layer]
    below: tuple[str, ...] = ()
    action: str = ""


def catalog_hierarchy(nodes: Mapping[str, CatalogNode]) -> str:
    """Return an SVG of catalogs, each above the catalogs that it joins.

    Args:
        nodes: Catalogs by name, each after the catalogs that it joins.
    """
    levels: dict[str, int] = {}
    for name, node in nodes.items():
        levels[name] = 1 + max((levels[each] for each in node.below), default=-1)
    icons = {name: icon_parts(node.words, node.layers) for name, node in nodes.items()}
    places, width, height = _places(levels, {name: tall for name, (tall, _) in icons.items()})
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        'font-family="sans-serif" font-size="13">',
        f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>',
    ]
    for name, node in nodes.items():
        start = (places[name][0] + ICON_WIDTH / 2, places[name][1] + icons[name][0] - _EDGE)
        for other in node.below:
            end = (places[other][0] + ICON_WIDTH / 2, places[other][1] + _EDGE)
            parts.append(_line(start, end))
        if node.below:
            parts.append(
                f'<text x="{start[0]:g}" y="{start[1] + 26:g}" text-anchor="middle" fill="{_INK}" '
                f'stroke="#ffffff" stroke-width="5" paint-order="stroke">'
                f"{escape(node.action)}</text>"
            )
    # Icons hide the lines that pass behind them.
    for name, (x, y) in places.items():
        parts += [f'<g transform="translate({x:g} {y:g})">', *icons[name][1], "</g>"]
    return "\n".join([*parts, "</svg>", ""])


def _places(
    levels: Mapping[str, int], heights: Mapping[str, int]
) -> tuple[dict[str, tuple[float, float]], float, float]:
    """Return the upper left corner of each icon, and the size of the drawing, px."""
    rows = [[name for name in levels if levels[name] == n] for n in range(1 + max(levels.values()))]
    widths = [len(row) * (ICON_WIDTH + _GAP) - _GAP for row in rows]
    width, top = 2 * _MARGIN + max(widths), float(_MARGIN)
    places: dict[str, tuple[float, float]] = {}
    for row, wide in reversed([*zip(rows, widths, strict=True)]):
        tallest = max(heights[name] for name in row)
        left = (width - wide) / 2
        for column, name in enumerate(row):
            # All icons of a row share one base line.
            places[name] = (left + column * (ICON_WIDTH + _GAP), top + tallest - heights[name])
        top += tallest + _RISE
    return places, width, top - _RISE + _MARGIN


def _line(start: tuple[float, float], end: tuple[float, float]) -> str:
    return (
        f'<line x1="{start[0]:g}" y1="{start[1]:g}" x2="{end[0]:g}" y2="{end[1]:g}" '
        f'stroke="{_LINE}"/>'
    )

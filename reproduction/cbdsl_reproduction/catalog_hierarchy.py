"""Hierarchy of catalogs: icons of objects, below icons of their combinations (Fig 7.10, 7.17)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.api.drawing import Layer
from cbdsl_reproduction.figure import drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# An icon has a width of 1. Height of a row, gap between rows, and rise between levels, in rows.
_ROW, _GAP, _RISE = 1.0, 0.1, 1.4
# Gap between icons, in icons.
_APART = 0.08
_ORANGE, _EMPTY, _OBJECT, _LINE = "#e69f00", "#fbeed2", "#dddddd", "#888888"


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


def catalog_hierarchy(title: str, nodes: Mapping[str, CatalogNode]) -> str:
    """Return an SVG of catalogs, each above the catalogs that it joins.

    Args:
        title: Title of the picture.
        nodes: Catalogs by name, each after the catalogs that it joins.
    """
    levels: dict[str, int] = {}
    for name, node in nodes.items():
        levels[name] = 1 + max((levels[each] for each in node.below), default=-1)
    layers = {name: _afforded(node.layers) for name, node in nodes.items()}
    heights = {name: (1 + len(own)) * _ROW for name, own in layers.items()}
    places, width, height = _places(levels, heights)
    with drawing(2.4 * width, 0.32 * height + 0.4, title) as draft:
        axes = draft.axes
        axes.set(xlim=(0, width), ylim=(height, 0))
        axes.set_axis_off()
        for name, node in nodes.items():
            x, y = places[name]
            start = (x + 0.5, y + heights[name])
            for other in node.below:
                end = (places[other][0] + 0.5, places[other][1])
                axes.plot(*zip(start, end, strict=True), color=_LINE, zorder=0, gid="joins")
            if node.below:
                words = axes.text(start[0], start[1] + 0.6, node.action, ha="center", va="center")
                words.set(parse_math=False, backgroundcolor="white")
            _draw_icon(axes, node.words, layers[name], x, y)
    return draft.svg


def _afforded(layers: Sequence[Layer]) -> list[Layer]:
    """Return the layers of rewarded actions, the surest one last."""
    rewarded = [layer for layer in layers if layer.rewarded]
    return sorted(rewarded, key=lambda layer: layer.rewarded / layer.tried)


def _draw_icon(axes: Axes, words: str, layers: Sequence[Layer], x: float, y: float) -> None:
    """Draw an object below its affordances; the filled share of a layer is that of rewards."""
    rows = [y + row * _ROW for row in range(len(layers) + 1)]
    thick = _ROW - _GAP
    shares = [layer.rewarded / layer.tried for layer in layers]
    axes.barh(rows[:-1], 1.0, left=x, color=_EMPTY, edgecolor=_ORANGE, height=thick, align="edge")
    axes.barh(rows[:-1], shares, left=x, color=_ORANGE, height=thick, align="edge")
    axes.barh(rows[-1:], 1.0, left=x, color=_OBJECT, height=thick, align="edge")
    middle = thick / 2
    for row, layer in zip(rows, layers, strict=False):
        counts = f"{layer.rewarded} of {layer.tried}"
        axes.text(x + 0.03, row + middle, layer.name, va="center").set_parse_math(False)
        axes.text(x + 0.97, row + middle, counts, va="center", ha="right")
    label = axes.text(x + 0.5, rows[-1] + middle, words, va="center", ha="center", weight="bold")
    label.set_parse_math(False)


def _places(
    levels: Mapping[str, int], heights: Mapping[str, float]
) -> tuple[dict[str, tuple[float, float]], float, float]:
    """Return the upper left corner of each icon, and the size of the drawing, in icons and rows."""
    rows = [[name for name in levels if levels[name] == n] for n in range(1 + max(levels.values()))]
    widths = [len(row) * (1 + _APART) - _APART for row in rows]
    width, top = max(widths), 0.0
    places: dict[str, tuple[float, float]] = {}
    for row, wide in reversed([*zip(rows, widths, strict=True)]):
        tallest = max(heights[name] for name in row)
        left = (width - wide) / 2
        for column, name in enumerate(row):
            # All icons of a row share one base line.
            places[name] = (left + column * (1 + _APART), top + tallest - heights[name])
        top += tallest + _RISE
    return places, width, top - _RISE

"""Graph of a meta-catalog: objects, stable pairs, and derived stacks (Figures 7.10, 7.17)."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.learning.catalogs.stack_plan import pairs_of, plan_stacks
from cbdsl.learning.catalogs.thing_graph import support_graph

_WIDTH, _HEIGHT, _GAP, _RISE, _MARGIN = 190, 44, 16, 76, 14
_ORANGE, _EMPTY, _INK, _THING, _LINE = "#e69f00", "#fbeed2", "#222222", "#dddddd", "#888888"
# Maximum number of drawn stacks of three, the surest first.
_STACKS = 6


class _Box(NamedTuple):
    """Box of the drawing.

    Attributes:
        words: Two lines of text.
        share: Filled share; ``None`` for an object.
        below: Keys of the boxes that it stands on.
        dashed: True if it was never tried.
    """

    words: tuple[str, str]
    share: float | None = None
    below: tuple[str, ...] = ()
    dashed: bool = False


def meta_catalog_graph(catalog: MetaCatalogDocument) -> str:
    """Return an SVG of a meta-catalog in three rows.

    The objects are at the bottom. Above them are the pairs that ever stayed, filled by their share
    of success. Above these, dashed, are the stacks of three that follow from the pairs.
    """
    rows = [_stacks(catalog), _pairs(catalog), _things(catalog)]
    # A catalog without rewarded pairs has neither pairs nor stacks to draw.
    rows = [row for row in rows if row]
    widest = max(len(row) for row in rows)
    width = 2 * _MARGIN + widest * (_WIDTH + _GAP) - _GAP
    height = 2 * _MARGIN + (len(rows) - 1) * (_HEIGHT + _RISE) + _HEIGHT
    places: dict[str, tuple[float, float]] = {}
    for level, row in enumerate(rows):
        left = (width - len(row) * (_WIDTH + _GAP) + _GAP) / 2
        for column, key in enumerate(row):
            x, y = left + column * (_WIDTH + _GAP), _MARGIN + level * (_HEIGHT + _RISE)
            places[key] = (x, y)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        f'font-family="sans-serif" font-size="13">',
        f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>',
    ]
    boxes = {key: box for row in rows for key, box in row.items()}
    # Lines come first, so that the boxes cover their ends.
    for key, box in boxes.items():
        parts += [_line(places[key], places[other], box) for other in box.below]
    for key, box in boxes.items():
        name = escape(key, quote=True)
        parts += [f'<g class="box" data-key="{name}">', *_drawn(box, *places[key]), "</g>"]
    return "\n".join([*parts, "</svg>", ""])


def pair_key(name: str) -> str:
    """Return the key of a pair's box in the drawing; the key of an object is its name."""
    return f"pair {name}"


def stack_key(order: Sequence[str]) -> str:
    """Return the key of a stack's box in the drawing, with objects ordered from below."""
    return "stack " + " ".join(order)


def _things(catalog: MetaCatalogDocument) -> dict[str, _Box]:
    return {
        name: _Box((name, thing.catalog or thing.meta_catalog or f"known by {thing.feature}"))
        for name, thing in catalog.things.items()
    }


def _pairs(catalog: MetaCatalogDocument) -> dict[str, _Box]:
    return {
        pair_key(name): _Box(
            (f"{pair.upper} {pair.relation}", f"{pair.lower}, {pair.rewarded} of {pair.tried}"),
            pair.rewarded / pair.tried,
            (pair.upper, pair.lower),
        )
        for name, pair in catalog.pairs.items()
        if pair.rewarded
    }


def _stacks(catalog: MetaCatalogDocument) -> dict[str, _Box]:
    """Return the stacks of three, each on its pairs."""
    boxes, support = {}, support_graph(catalog)
    for plan in plan_stacks(support, 3)[:_STACKS]:
        low, middle, top = plan.order
        below = tuple(map(pair_key, pairs_of(support, plan.order)))
        words = (f"{top} on {middle}", f"on {low}, {plan.probability:.2f}")
        boxes[stack_key(plan.order)] = _Box(words, plan.probability, below, dashed=True)
    return boxes


def _line(upper: tuple[float, float], lower: tuple[float, float], box: _Box) -> str:
    x, y = upper[0] + _WIDTH / 2, upper[1] + _HEIGHT
    dash = ' stroke-dasharray="5 4"' if box.dashed else ""
    end = f'x2="{lower[0] + _WIDTH / 2:g}" y2="{lower[1]:g}"'
    return f'<line x1="{x:g}" y1="{y:g}" {end} stroke="{_LINE}"{dash}/>'


def _drawn(box: _Box, x: float, y: float) -> Sequence[str]:
    frame = f'x="{x:g}" y="{y:g}" height="{_HEIGHT}" rx="5"'
    dash = ' stroke-dasharray="5 4"' if box.dashed else ""
    if box.share is None:
        parts = [f'<rect {frame} width="{_WIDTH}" fill="{_THING}"/>']
    else:
        filled = round(_WIDTH * box.share, 1)
        parts = [
            f'<rect {frame} width="{_WIDTH}" fill="{_EMPTY}"/>',
            f'<rect {frame} width="{filled:g}" fill="{_ORANGE}"/>',
            f'<rect {frame} width="{_WIDTH}" fill="none" stroke="{_ORANGE}"{dash}/>',
        ]
    for row, words in enumerate(box.words):
        parts.append(
            f'<text x="{x + _WIDTH / 2:g}" y="{y + 18 + 17 * row:g}" text-anchor="middle" '
            f'font-weight="{"bold" if box.share is None and row == 0 else "normal"}" '
            f'fill="{_INK}">{escape(words)}</text>'
        )
    return parts

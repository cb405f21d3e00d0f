"""Where the nodes of a directed graph go, in rows from top to bottom, and how arcs lead to them.

The steps are those of Sugiyama, Tagawa and Toda (1981): rows, an order with few crossings, places.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

Key = str
Point = tuple[float, float]

_SWEEPS = 12
# Weights for straight arcs between two nodes, a node and a passage, or two passages.
_STRAIGHT = (2, 1, 8)
#: Number of nodes without any arc that share a row.
_LOOSE = 4


class Size(NamedTuple):
    """Size of a node, px."""

    width: float
    height: float


class Spacing(NamedTuple):
    """Space between elements, px.

    Attributes:
        across: Distance between nodes of a row.
        down: Distance between rows.
        lane: Width of an arc that passes a row.
    """

    across: float
    down: float
    lane: float


class Layout(NamedTuple):
    """Layout of a drawing.

    Attributes:
        centers: Centres of the nodes, from the upper left corner of the drawing, px.
        routes: Points of each arc, from the border of one node to the border of the other, px.
        size: Size of the drawing, px.
    """

    centers: Mapping[Key, Point]
    routes: Mapping[tuple[Key, Key], tuple[Point, ...]]
    size: Size


class _Cell(NamedTuple):
    """Node in its row, or the place of an arc that passes a row."""

    row: int
    arc: tuple[Key, Key] | None
    node: Key | None


# Layered drawing of a directed graph, after Sugiyama, Tagawa and Toda (1981), in three steps:
# 1. Rows. The row of a node is its distance, in arcs, from the first root that reaches it.
#    Cycles are allowed: an arc may lead upwards, or stay within its row.
# 2. Order. Each row is sorted by the mean places of the neighbours in an adjacent row.
#    Sweeps alternate downwards and upwards; the order with the fewest crossings is kept.
# 3. Places. Cells approach the weighted mean of their neighbours at a minimum distance from
#    each other. Within one row, this least-squares problem is solved exactly.
# An arc over several rows has a cell in each row that it passes, so that it crosses no node.
# All steps are heuristics, deterministic, and for tens of nodes: the count of crossings is
# quadratic in the arcs between two rows.
def lay_out(
    sizes: Mapping[Key, Size],
    arcs: Sequence[tuple[Key, Key]],
    roots: Iterable[Key],
    spacing: Spacing,
) -> Layout:
    """Place nodes in rows, and route the arcs between them.

    Args:
        sizes: Sizes of the nodes, px.
        arcs: Arcs between different nodes.
        roots: Nodes in the first row.
        spacing: Space between elements.
    """
    rows_of = _rows(list(sizes), arcs, list(roots))
    chains = {arc: _chain(arc, rows_of) for arc in arcs}
    rows = _order(_cells(rows_of, chains), list(chains.values()))
    widths = {
        cell: spacing.lane if cell.node is None else sizes[cell.node].width
        for row in rows
        for cell in row
    }
    places = _places(rows, list(chains.values()), widths, spacing.across)
    tall = [max((sizes[c.node].height for c in row if c.node), default=0.0) for row in rows]
    tops = [sum(tall[:number]) + number * spacing.down for number in range(len(rows))]
    middles = [top + height / 2 for top, height in zip(tops, tall, strict=True)]
    centers = {c.node: (x, middles[c.row]) for c, x in places.items() if c.node is not None}
    width = max((x + widths[cell] / 2 for cell, x in places.items()), default=0.0)
    height = tops[-1] + tall[-1] if rows else 0.0
    routes = _routes(chains, places, sizes, (tops, tall, middles), spacing)
    return Layout(centers, routes, Size(width, height))


def _rows(
    nodes: Sequence[Key], arcs: Sequence[tuple[Key, Key]], roots: list[Key]
) -> dict[Key, int]:
    """Return the row of each node: its distance in arcs from a root."""
    after: dict[Key, list[Key]] = {node: [] for node in nodes}
    for source, target in arcs:
        after[source].append(target)
    joined = {node for arc in arcs for node in arc}
    row_of: dict[Key, int] = {}
    # Nodes that no root reaches begin searches of their own, also in the first row.
    for root in (*roots, *(node for node in nodes if node in joined)):
        waiting = [root] if root not in row_of else []
        row_of.setdefault(root, 0)
        while waiting:
            node = waiting.pop(0)
            for target in after[node]:
                if target not in row_of:
                    row_of[target] = row_of[node] + 1
                    waiting.append(target)
    # Nodes without arcs come last, a few in a row. In the first row, they would make the drawing
    # too wide.
    loose = [node for node in nodes if node not in row_of]
    first = max(row_of.values(), default=-1) + 1
    return row_of | {node: first + place // _LOOSE for place, node in enumerate(loose)}


def _chain(arc: tuple[Key, Key], rows: Mapping[Key, int]) -> tuple[_Cell, ...]:
    """Return the cells of an arc: its source, the cells in passed rows, and its target."""
    (source, target), (first, last) = arc, (rows[arc[0]], rows[arc[1]])
    step = 1 if last > first else -1
    # An arc within a row passes no row; `_routes` draws it as one bow.
    passed = range(first + step, last, step) if first != last else range(0)
    return (
        _Cell(first, None, source),
        *(_Cell(row, arc, None) for row in passed),
        _Cell(last, None, target),
    )


def _cells(
    rows: Mapping[Key, int], chains: Mapping[tuple[Key, Key], tuple[_Cell, ...]]
) -> list[list[_Cell]]:
    rows_: list[list[_Cell]] = [[] for _ in range(max(rows.values(), default=-1) + 1)]
    for node, row in rows.items():
        rows_[row].append(_Cell(row, None, node))
    for chain in chains.values():
        for cell in chain[1:-1]:
            rows_[cell.row].append(cell)
    return rows_


def _neighbours(chains: Sequence[tuple[_Cell, ...]]) -> dict[_Cell, list[_Cell]]:
    near: dict[_Cell, list[_Cell]] = {}
    for chain in chains:
        for one, other in pairwise(chain):
            if one.row != other.row:
                near.setdefault(one, []).append(other)
                near.setdefault(other, []).append(one)
    return near


def _order(rows: list[list[_Cell]], chains: Sequence[tuple[_Cell, ...]]) -> list[list[_Cell]]:
    """Return the rows with the fewest crossings found by barycentre sweeps."""
    near = _neighbours(chains)
    best, fewest = rows, _crossings(rows, near)
    for sweep in range(_SWEEPS):
        step = 1 if sweep % 2 == 0 else -1
        rows = [list(row) for row in rows]
        for number in range(len(rows))[::step]:
            if 0 <= number - step < len(rows):
                # Downwards, the row above is fixed, and upwards the row below.
                beside = {cell: place for place, cell in enumerate(rows[number - step])}
                rows[number] = _by_barycentre(rows[number], beside, near)
        crossings = _crossings(rows, near)
        if crossings < fewest:
            best, fewest = rows, crossings
    return best


def _by_barycentre(
    row: list[_Cell], beside: Mapping[_Cell, int], near: Mapping[_Cell, list[_Cell]]
) -> list[_Cell]:
    def weight(place: int) -> float:
        # A cell without neighbours there keeps its place as its weight. The sort is stable.
        places = [beside[cell] for cell in near.get(row[place], ()) if cell in beside]
        return sum(places) / len(places) if places else float(place)

    return [row[place] for place in sorted(range(len(row)), key=weight)]


def _crossings(rows: Sequence[Sequence[_Cell]], near: Mapping[_Cell, list[_Cell]]) -> int:
    total = 0
    for upper, lower in pairwise(rows):
        below = {cell: place for place, cell in enumerate(lower)}
        ends = [
            (place, below[other])
            for place, cell in enumerate(upper)
            for other in near.get(cell, ())
            if other in below
        ]
        # Both strict comparisons have one direction, so that each pair counts once, and shared ends
        # do not count.
        total += sum(a < c and b > d for a, b in ends for c, d in ends)
    return total


def _places(
    rows: Sequence[Sequence[_Cell]],
    chains: Sequence[tuple[_Cell, ...]],
    widths: Mapping[_Cell, float],
    across: float,
) -> dict[_Cell, float]:
    """Return horizontal centres, each close to its neighbours' mean, with enough space between."""
    near = _neighbours(chains)
    places: dict[_Cell, float] = {}
    for row in rows:
        places |= _apart(row, dict.fromkeys(row, 0.0), widths, across)
    for sweep in range(_SWEEPS):
        for row in rows if sweep % 2 == 0 else rows[::-1]:
            wanted = {cell: _wanted(cell, near.get(cell, []), places) for cell in row}
            places |= _apart(row, wanted, widths, across)
    left = min((x - widths[cell] / 2 for cell, x in places.items()), default=0.0)
    return {cell: x - left for cell, x in places.items()}


def _wanted(cell: _Cell, near: Sequence[_Cell], places: Mapping[_Cell, float]) -> float:
    """Return the mean place of a cell's neighbours, weighted so that long arcs are straight."""
    weights = [_STRAIGHT[(cell.node is None) + (other.node is None)] for other in near]
    if not near:
        return places[cell]
    pull = sum(weight * places[other] for weight, other in zip(weights, near, strict=True))
    return pull / sum(weights)


def _apart(
    row: Sequence[_Cell],
    wanted: Mapping[_Cell, float],
    widths: Mapping[_Cell, float],
    across: float,
) -> dict[_Cell, float]:
    """Return the places with the least squared distance from the desired places of a row's cells.

    After subtraction of the space for preceding cells, places may not decrease: isotonic
    regression, by pooling adjacent violators.
    """
    # The offset of a cell is its least distance from the first cell of the row.
    offsets, offset = [], 0.0
    for before, cell in zip((None, *row), row, strict=False):
        offset += 0.0 if before is None else (widths[before] + widths[cell]) / 2 + across
        offsets.append(offset)
    # A pool is a run of cells with equal levels. Pools merge, weighted by their sizes, until levels
    # do not decrease.
    pools: list[tuple[float, int]] = []
    for cell, offset in zip(row, offsets, strict=True):
        mean, size = wanted[cell] - offset, 1
        while pools and pools[-1][0] > mean:
            before_mean, before_size = pools.pop()
            mean = (mean * size + before_mean * before_size) / (size + before_size)
            size += before_size
        pools.append((mean, size))
    level = [mean for mean, size in pools for _ in range(size)]
    return {cell: x + o for cell, x, o in zip(row, level, offsets, strict=True)}


_Heights = tuple[Sequence[float], Sequence[float], Sequence[float]]


def _routes(
    chains: Mapping[tuple[Key, Key], tuple[_Cell, ...]],
    across: Mapping[_Cell, float],
    sizes: Mapping[Key, Size],
    heights: _Heights,
    spacing: Spacing,
) -> dict[tuple[Key, Key], tuple[Point, ...]]:
    """Return the points of all arcs; ports share a node's side in the order of the arcs."""
    ports = _ports(chains, across, sizes)
    tops, tall, middles = heights
    routes = {}
    for arc, chain in chains.items():
        points: list[Point] = []
        for end in (0, -1):
            cell = chain[end]
            half = sizes[cell.node or ""].height / 2
            side = half if _below(chain, end, across) else -half
            points.append((ports[arc, end], middles[cell.row] + side))
        between: list[Point] = []
        for cell in chain[1:-1]:
            # Two points for each passed row keep the arc straight in the gap between its nodes.
            rim = tops[cell.row], tops[cell.row] + tall[cell.row]
            down = chain[-1].row > chain[0].row
            between += [(across[cell], y) for y in (rim if down else rim[::-1])]
        if chain[0].row == chain[-1].row:
            reach = spacing.down * (0.45 if _below(chain, 0, across) else -0.45)
            between = [((points[0][0] + points[1][0]) / 2, points[0][1] + reach)]
        routes[arc] = (points[0], *between, points[1])
    return routes


def _below(chain: Sequence[_Cell], end: int, across: Mapping[_Cell, float]) -> bool:
    """Return whether an arc meets the lower side of its source (``end`` 0) or target (-1).

    Within a row, arcs to the right go below both, and arcs to the left above.
    """
    source, target = chain[0], chain[-1]
    if source.row == target.row:
        return across[target] > across[source]
    return (target.row > source.row) == (end == 0)


def _ports(
    chains: Mapping[tuple[Key, Key], tuple[_Cell, ...]],
    across: Mapping[_Cell, float],
    sizes: Mapping[Key, Size],
) -> dict[tuple[tuple[Key, Key], int], float]:
    """Return the horizontal position at which each end of each arc meets its node, px."""
    sides: dict[tuple[_Cell, bool], list[tuple[float, tuple[Key, Key], int]]] = {}
    for arc, chain in chains.items():
        for end, other in ((0, 1), (-1, -2)):
            side = chain[end], _below(chain, end, across)
            sides.setdefault(side, []).append((across[chain[other]], arc, end))
    ports = {}
    for (cell, _), ends in sides.items():
        width = sizes[cell.node or ""].width
        # In the order of the next cells, arcs of one side do not cross near the node. Ports stay
        # off the corners, within 90 % of the side.
        for place, (_, arc, end) in enumerate(sorted(ends), start=1):
            ports[arc, end] = across[cell] + width * (place / (len(ends) + 1) - 0.5) * 0.9
    return ports

"""Graphs as pictures: nodes in rows or columns, states as pictograms, smooth labelled arcs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from textwrap import wrap
from typing import NamedTuple
from xml.sax.saxutils import escape, quoteattr

from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, Vertex
from cbdsl.reporting.drawing.layers import Point, Size, Spacing, lay_out
from cbdsl.reporting.drawing.pictogram import EDGE, LETTERS, PITCH, pictogram, pictograms, width

#: Size of letters, px.
SIZE = 13
# A letter of the monospaced font is 0.6 times as wide as high; some fonts are a bit wider.
_LETTER = 0.64

#: Font in CSS notation.
FONT = f'{SIZE}px "DejaVu Sans Mono", Menlo, Consolas, monospace'
#: Height of a line of text, px.
LINE = 18
#: Size of small letters, px.
SMALL = 11


def text_width(line: str, size: float = SIZE) -> float:
    """Return the maximum width of a line in a font of some size, px."""
    return len(line) * _LETTER * size


def text(line: str, x: float, y: float, kind: str = "") -> str:
    """Return a line of text with its middle at height ``y``.

    It begins at ``x``, or is centred there if its class says so.
    """
    style = f' class="{kind}"' if kind else ""
    return f'<text{style} x="{x:.1f}" y="{y:.1f}">{escape(line)}</text>'


def rectangle(kind: str, x: float, y: float, width: float, height: float, round_: float = 4) -> str:
    """Return a rectangle with rounded corners, of the class ``kind``.

    ``x`` and ``y`` are its upper left corner, px.
    """
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f'<rect class="{kind}" {place} rx="{round_:g}"/>'


_PAD = 10
_MARGIN = 16
_LOOP = 56
_NARROWEST = 330
# Largest number of lines by which rows are moved apart to free labels.
_WIDER = 12
_DOWN = Spacing(across=26, down=62, lane=30)
_START = 26
_HEAD = 9.0
# Height of a line of a label, px.
_LABEL = SMALL + 2
#: Distance between a node and its second frame, px.
_RIM = 4
#: Heights of lines with other than the standard height, by kind, px.
_HEIGHTS = {"fact": LINE - 3}

# All rules are below .graph, because other pictures on a page have their own styles.
_STYLE = f"""
  .graph {{ background: #fff; font: {FONT}; }}
  .graph text {{ fill: #1d2126; dominant-baseline: central; }}
  .graph .name {{ font-weight: bold; }}
  .graph .action {{ fill: #0b4f8a; font-weight: bold; text-anchor: middle; }}
  .graph .reward {{ fill: #23762f; }}
  .graph .fact {{ fill: #5c656f; font-size: {SMALL}px; text-anchor: middle; }}
  .graph .note {{ fill: #5c656f; font-size: {SMALL}px; }}
  .graph .share {{ font-size: {SMALL}px; text-anchor: middle; }}
  .graph .ground {{ fill: #fff; }}
  .graph .node {{ fill: #f6f7f9; stroke: #8a94a0; }}
  .graph .selector-node {{ fill: #fff3d6; stroke: #a67c00; }}
  .graph .pattern-node, .graph .end-node {{ fill: #fff; stroke: #a67c00; }}
  .graph .action-node {{ fill: #e3eefb; stroke: #2f6db3; }}
  .graph .ending {{ fill: none; stroke: #8a94a0; }}
  .graph .ending.rewarded {{ stroke: #1a7f37; stroke-width: 2; }}
  .graph .now > rect {{ fill: #ffd54a; stroke: #7a5b00; stroke-width: 3; }}
  .graph .arc {{ fill: none; stroke: #555; }}
  .graph .tip {{ fill: #555; }}
"""


class _Label(NamedTuple):
    """Place of an arc's label, px."""

    x: float
    y: float
    width: float
    height: float

    def meets(self, other: _Label) -> bool:
        """Return whether two labels overlap."""
        near = abs(self.x - other.x) < (self.width + other.width) / 2
        return near and abs(self.y - other.y) < (self.height + other.height) / 2


def svg(graph: Graph) -> str:
    """Return a graph as SVG; the graphs within it follow below."""
    graphs = _all(graph, [])
    keys = _keys(graphs)
    panels = [_Panel(each, graphs, keys) for each in graphs]
    wide = max(panel.width for panel in panels)
    body: list[str] = []
    top = float(_MARGIN)
    for panel in panels:
        body += panel.lines(top, wide)
        top += panel.height
    legend = list(_legend(graph, panels, _MARGIN, top, wide))
    bottom = top + _legend_height(graph, panels, wide)
    size = f'width="{wide + 2 * _MARGIN:.0f}" height="{bottom:.0f}"'
    box = f'viewBox="0 0 {wide + 2 * _MARGIN:.0f} {bottom:.0f}"'
    description = escape(" ".join(node.tooltip for node in graph.nodes if node.tooltip))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="graph" {size} {box} role="img">\n'
        f"<title>{escape(graph.title)}</title>\n<desc>{description}</desc>\n"
        f"<style>{_STYLE}</style>\n" + "\n".join((*body, *legend)) + "\n</svg>\n"
    )


def _all(graph: Graph, seen: list[Graph]) -> list[Graph]:
    """Return a graph and all graphs within it, each once."""
    # A program that several actions use is drawn once; their nodes link to it.
    if graph not in seen:
        seen.append(graph)
        for node in graph.nodes:
            if node.inner is not None:
                _all(node.inner, seen)
    return seen


def _keys(graphs: Sequence[Graph]) -> list[str]:
    """Return a distinct identifier for each graph: its name, with a number if it is repeated."""
    # One program may occur with several arguments, such as a search for either of two objects.
    names = [graph.name for graph in graphs]
    counts = [names[: place + 1].count(name) for place, name in enumerate(names)]
    return [
        name if number == 1 else f"{name}-{number}"
        for name, number in zip(names, counts, strict=True)
    ]


class _Panel:
    """Layout and drawing of one graph.

    Args:
        graph: Graph to draw.
        graphs: All graphs of the picture.
        keys: Identifiers of these graphs.
    """

    def __init__(self, graph: Graph, graphs: Sequence[Graph], keys: Sequence[str]) -> None:
        self.graph = graph
        self._graphs, self._keys = graphs, keys
        self._loops = {edge.source: edge for edge in graph.edges if edge.source == edge.target}
        self._arcs = [edge for edge in graph.edges if edge.source != edge.target]
        self._sizes = _sizes(graph, self._loops)
        ways = [(edge.source, edge.target) for edge in self._arcs]
        roots = [node.key for node in graph.nodes if node.started] or [graph.nodes[0].key]
        # Rows part until each label has a free place on its arc.
        for more in range(_WIDER):
            down = _spacing([edge.label for edge in self._arcs], more)
            self._layout = lay_out(self._sizes, ways, roots, down)
            self._drawn = [_path(self._layout.routes[way]) for way in ways]
            self._labels, is_free = self._placed_labels()
            if is_free:
                break
        started = _START if any(node.started for node in graph.nodes) else 0
        self._above = LINE + max(started, _MARGIN / 2)
        # A label may reach beyond the nodes.
        rims = [
            (each.x - each.width / 2, each.x + each.width / 2) for each in self._labels.values()
        ]
        self._left = min((left for left, _ in rims), default=0.0)
        self._left = min(self._left, 0.0)
        self._right = max((self._layout.size.width, *(right for _, right in rims)))
        self.width = max(self._right - self._left, _NARROWEST, text_width(graph.title))
        below = max(2 * _MARGIN, 0.7 * down.down)  # for arcs within the last row
        self.height = self._above + self._layout.size.height + below

    def _placed_labels(self) -> tuple[dict[int, _Label], bool]:
        """Return the labels by the number of their arc, and true if none overlaps."""
        nodes = [
            _Label(*self._layout.centers[key], own.width, own.height + 4)
            for key, own in self._sizes.items()
        ]
        labels: dict[int, _Label] = {}
        is_free = True
        # Long labels have the fewest free places.
        ways = sorted(enumerate(self._arcs), key=lambda way: -way[1].label.count("\n"))
        for number, arc in ways:
            if lines := arc.label.splitlines():
                size = Size(text_width(max(lines, key=len), SMALL), len(lines) * _LABEL)
                points = self._drawn[number][1]
                labels[number], is_alone = _label(points, size, [*labels.values(), *nodes])
                is_free &= is_alone
        return labels, is_free

    def lines(self, top: float, wide: float) -> Iterator[str]:
        """Yield the panel from ``top`` downwards, centred in a width, px."""
        left = _MARGIN + (wide - self._left - self._right) / 2
        yield f"<g id={quoteattr(self._key(self.graph))}>"
        yield text(self.graph.title, _MARGIN, top, "name")
        yield f'<g transform="translate({left:.1f} {top + self._above:.1f})">'
        yield from self._paths()
        for node in self.graph.nodes:
            yield from self._node(node)
        yield "</g></g>"

    def _key(self, graph: Graph) -> str:
        """Return the identifier of one of the picture's graphs."""
        return self._keys[self._graphs.index(graph)]

    def _node(self, node: Vertex) -> Iterator[str]:
        x, y = self._layout.centers[node.key]
        loop, size, rim = self._loops.get(node.key), self._sizes[node.key], _rim(node)
        wide, tall = size.width - (2 * _LOOP if loop else 0), size.height
        outer, top = y - tall / 2, y - tall / 2 + rim
        link = None if node.inner is None else quoteattr(f"#{self._key(node.inner)}")
        kind = f"a href={link}" if link else "g"
        yield f"<{kind} data-node={quoteattr(node.key)}><title>{escape(node.tooltip)}</title>"
        if rim:
            yield rectangle(node.frame, x - wide / 2, outer, wide, tall, 10)
        kind = "node" if node.shape is Outline.STATE else f"{node.shape}-node"
        round_ = min(tall / 2, 16) if node.shape in (Outline.PATTERN, Outline.END) else 7
        yield rectangle(kind, x - wide / 2 + rim, top, wide - 2 * rim, tall - 2 * rim, round_)
        left = x - width(node.letters) / 2
        yield from pictograms(
            node.letters, self.graph.members, self.graph.programs, left, top + _pad(node)
        )
        yield from _label_lines(node, x, x - wide / 2 + _PAD, top)
        if node.started:
            yield f'<circle class="tip" cx="{x:.1f}" cy="{outer - _START + 4:.1f}" r="4"/>'
            yield f'<path class="arc" d="M{x:.1f} {outer - _START + 4:.1f}V{outer - 8:.1f}"/>'
            yield _tip((x, outer), 90)
        if loop is not None:
            yield from _looped(loop, x + wide / 2, y)
        yield "</a>" if link else "</g>"

    def _paths(self) -> Iterator[str]:
        """Yield the arcs, and then their labels, so that no arc hides a label."""
        for arc, (path, points) in zip(self._arcs, self._drawn, strict=True):
            yield f'<path class="arc" d="{path}" stroke-width="{_thickness(arc):.1f}"/>'
            # The last two samples give the direction in which the arc reaches its node.
            (_, y1), (_, y2) = points[-2:]
            yield _tip(points[-1], 90 if y2 > y1 else -90)
        for number, place in self._labels.items():
            yield _ground(place)
            top = place.y - (place.height - _LABEL) / 2
            for row, line in enumerate(self._arcs[number].label.splitlines()):
                yield text(line, place.x, top + row * _LABEL, "share")


def _spacing(labels: Sequence[str], more: int) -> Spacing:
    """Return the space between rows and their nodes, with room for labels and ``more`` lines."""
    more += max((label.count("\n") for label in labels), default=0)
    return Spacing(_DOWN.across + 6 * more, _DOWN.down + more * _LABEL, _DOWN.lane)


def _sizes(graph: Graph, loops: dict[str, Edge]) -> dict[str, Size]:
    """Return the nodes' sizes; all patterns have the same width, and so do all actions."""
    sizes = {node.key: _size(node, node.key in loops) for node in graph.nodes}
    for column in ((Outline.PATTERN,), (Outline.ACTION, Outline.END)):
        own = [node.key for node in graph.nodes if node.shape in column]
        widest = max((sizes[key].width for key in own), default=0.0)
        sizes |= {key: sizes[key]._replace(width=widest) for key in own}
    return sizes


def _size(node: Vertex, loop: bool) -> Size:
    texts = [text_width(line.text, SMALL if line.kind == "fact" else SIZE) for line in node.lines]
    wide = max([width(node.letters) if node.letters else 0.0, *texts])
    tall = (EDGE if node.letters else 0) + sum(_HEIGHTS.get(line.kind, LINE) for line in node.lines)
    tall += 2 if node.letters and node.lines else 0
    rim = 2 * _rim(node)
    return Size(wide + 2 * _PAD + (2 * _LOOP if loop else 0) + rim, tall + 2 * _pad(node) + rim)


def _pad(node: Vertex) -> float:
    return _PAD if node.shape is Outline.STATE else _PAD / 2


def _rim(node: Vertex) -> int:
    return _RIM if node.frame else 0


def _label_lines(node: Vertex, middle: float, left: float, top: float) -> Iterator[str]:
    """Yield the lines of a node, centred if they are below pictograms."""
    y = top + _pad(node) + (EDGE + 2 if node.letters else 0)
    for line in node.lines:
        y += _HEIGHTS.get(line.kind, LINE)
        yield text(line.text, middle if node.letters else left, y - LINE / 2 + 1, line.kind)


def _tip(end: Point, turned: float) -> str:
    """Return the tip of an arrow that points to the right, turned clockwise by an angle, deg."""
    place = f"translate({end[0]:.1f} {end[1]:.1f}) rotate({turned:g})"
    return f'<path class="tip" transform="{place}" d="M0 0l{-_HEAD:g} -4.5v9z"/>'


def _looped(arc: Edge, x: float, y: float) -> Iterator[str]:
    yield (
        f'<path class="arc" d="M{x:.1f} {y - 9:.1f}c24 -14 24 32 {_HEAD - 1:.1f} 20" '
        f'stroke-width="{_thickness(arc):.1f}"/>'
    )
    yield _tip((x, y + 11), 180)
    yield text(arc.label, x + 38, y, "share")


def _ground(label: _Label) -> str:
    wide, tall = label.width - 2, label.height
    return rectangle("ground", label.x - wide / 2, label.y - tall / 2, wide, tall, 2)


def _thickness(arc: Edge) -> float:
    return 0.8 + 2.2 * arc.weight


# An arc is a chain of cubic Bezier curves with vertical tangents at all points of its route. The
# control points are at half the height between two route points, so that the chain has no corners.
# Within a row, the route has one middle point. Its curve bows beyond this point: by half of its
# distance if both ends are at the same height.
def _path(route: Sequence[Point]) -> tuple[str, list[Point]]:
    """Return a route as a smooth path that begins and ends vertically, and points along it."""
    if len(route) == 3:  # within a row: one bow
        (x1, y1), (_, y), (x2, y2) = route
        bows = [((x1, y1), (x1, 2 * y - y1), (x2, 2 * y - y1), (x2, y2))]
    else:
        bows = [
            ((x1, y1), (x1, (y1 + y2) / 2), (x2, (y1 + y2) / 2), (x2, y2))
            for (x1, y1), (x2, y2) in pairwise(route)
        ]
    # Samples for labels and the tip precede the next step, which shortens the arc.
    points = [_on(bow, step / 16) for bow in bows for step in range(17)]
    start, control, approach, end = bows[-1]
    # The line ends within the tip. A line up to the border would show beside the point of the tip.
    back = math.copysign(_HEAD - 1, end[1] - approach[1])
    bows[-1] = (start, control, approach, (end[0], end[1] - back))
    steps = [bows[0][0], *(point for bow in bows for point in bow[1:])]
    drawn = " ".join(f"{x:.1f} {y:.1f}" for x, y in steps[1:])
    return f"M{steps[0][0]:.1f} {steps[0][1]:.1f}C{drawn}", points


def _on(bow: Sequence[Point], t: float) -> Point:
    """Return a point on a cubic Bezier curve, ``t`` from 0 to 1."""
    weights = ((1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3)
    x = sum(weight * point[0] for weight, point in zip(weights, bow, strict=True))
    y = sum(weight * point[1] for weight, point in zip(weights, bow, strict=True))
    return x, y


def _label(points: Sequence[Point], size: Size, taken: Sequence[_Label]) -> tuple[_Label, bool]:
    """Return a label near the first third of an arc, and true if it overlaps no taken place."""
    places = sorted(range(len(points)), key=lambda place: abs(place - len(points) // 3))
    labels = [_Label(*points[place], *size) for place in places]
    free = (each for each in labels if not any(map(each.meets, taken)))
    # An overlap is better than a missing label.
    label = next(free, None)
    return label or labels[0], label is not None


def _letters(panels: Sequence[_Panel]) -> list[str]:
    """Return the letters of the legend: none without states, ``*`` only if it is used."""
    if not any(panel.graph.members for panel in panels):
        return []
    used = "".join(node.letters for panel in panels for node in panel.graph.nodes)
    return [letter for letter in LETTERS if letter != "*" or "*" in used]


def _columns(wide: float) -> int:
    """Return the number of entries of the legend that fit beside each other."""
    return next(columns for columns in (5, 4, 2, 1) if columns * _entry() <= wide or columns == 1)


def _entry() -> float:
    return PITCH + max(text_width(letter.meaning, SMALL) for letter in LETTERS.values()) + 8


def _note_lines(graph: Graph, wide: float) -> list[str]:
    room = int(wide / text_width("m", SMALL))
    return [line for note in graph.notes for line in wrap(note, room)]


def _legend_height(graph: Graph, panels: Sequence[_Panel], wide: float) -> float:
    rows = -(-len(_letters(panels)) // _columns(wide))
    return rows * (EDGE + 6) + 6 + len(_note_lines(graph, wide)) * (LINE - 2) + _MARGIN / 2


def _legend(
    graph: Graph, panels: Sequence[_Panel], left: float, top: float, wide: float
) -> Iterator[str]:
    letters, columns = _letters(panels), _columns(wide)
    for number, letter in enumerate(letters):
        x = left + number % columns * _entry()
        y = top + number // columns * (EDGE + 6)
        yield pictogram(letter, False, x, y)
        yield text(LETTERS[letter].meaning, x + PITCH, y + EDGE / 2, "note")
    below = top + -(-len(letters) // columns) * (EDGE + 6) + 6 + LINE / 2
    for number, line in enumerate(_note_lines(graph, wide)):
        yield text(line, left, below + number * (LINE - 2), "note")

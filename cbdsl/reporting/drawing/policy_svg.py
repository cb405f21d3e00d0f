"""Policies as pictures: states as pictograms, and which follows which, from top to bottom."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from textwrap import wrap
from typing import NamedTuple
from xml.sax.saxutils import escape

from cbdsl.reporting.drawing.layers import Layout, Point, Size, Spacing, lay_out
from cbdsl.reporting.drawing.pictogram import (
    EDGE,
    LETTERS,
    PITCH,
    pictogram,
    pictograms,
    width,
)
from cbdsl.reporting.drawing.policy_graph import Arc, Decision, PolicyGraph
from cbdsl.reporting.drawing.policy_words import facts, notes, percent, sentence, title
from cbdsl.reporting.drawing.shapes import FONT, LINE, rectangle, text, text_width

_PAD = 10
_MARGIN = 16
_SMALL = 11
_LOOP = 56
_NARROWEST = 330
_SPACING = Spacing(across=26, down=62, lane=30)
_START = 26
_HEAD = 9.0
#: Between a state and the second frame of one that ends episodes.
_RIM = 4

# Everything is below .policy: on a page, other pictures have styles of their own.
_STYLE = f"""
  .policy {{ background: #fff; font: {FONT}; }}
  .policy text {{ fill: #1d2126; dominant-baseline: central; }}
  .policy .name {{ font-weight: bold; }}
  .policy .action {{ fill: #0b4f8a; font-weight: bold; text-anchor: middle; }}
  .policy .fact {{ fill: #5c656f; font-size: {_SMALL}px; text-anchor: middle; }}
  .policy .note {{ fill: #5c656f; font-size: {_SMALL}px; }}
  .policy .share {{ font-size: {_SMALL}px; text-anchor: middle; }}
  .policy .ground {{ fill: #fff; }}
  .policy .node {{ fill: #f6f7f9; stroke: #8a94a0; }}
  .policy .ending {{ fill: none; stroke: #8a94a0; }}
  .policy .ending.rewarded {{ stroke: #1a7f37; stroke-width: 2; }}
  .policy .arc {{ fill: none; stroke: #555; }}
  .policy .tip {{ fill: #555; }}
"""


class _Box(NamedTuple):
    """Where a label is, px."""

    x: float
    y: float
    width: float

    def meets(self, other: _Box) -> bool:
        """Whether two labels overlap."""
        near = abs(self.x - other.x) < (self.width + other.width) / 2
        return near and abs(self.y - other.y) < _SMALL + 2


def policy_svg(graph: PolicyGraph) -> str:
    """A policy as SVG."""
    sizes = {decision.state: _size(graph, decision) for decision in graph.decisions}
    arcs = [(arc.source, arc.target) for arc in graph.arcs if arc.source != arc.target]
    began = [decision.state for decision in graph.decisions if decision.started]
    layout = lay_out(sizes, arcs, began, _SPACING)
    name = title(graph)
    wide = max(layout.size.width, _NARROWEST, text_width(name))
    top, left = _MARGIN + LINE + _START, _MARGIN + (wide - layout.size.width) / 2
    legend = list(_legend(graph, _MARGIN, top + layout.size.height + 2 * _MARGIN, wide))
    bottom = top + layout.size.height + 2 * _MARGIN + _legend_height(graph, wide)
    picture = (
        f'<g transform="translate({left:.1f} {top})">', *_arcs(graph, layout, sizes),
        *(line for decision in graph.decisions for line in _node(graph, decision, layout, sizes)),
        "</g>",
    )  # fmt: skip
    size = f'width="{wide + 2 * _MARGIN:.0f}" height="{bottom:.0f}"'
    box = f'viewBox="0 0 {wide + 2 * _MARGIN:.0f} {bottom:.0f}"'
    told = escape(" ".join(sentence(graph, decision) for decision in graph.decisions))
    body = "\n".join((text(name, _MARGIN, _MARGIN, "name"), *picture, *legend))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="policy" {size} {box} role="img">\n'
        f"<title>{escape(name)}</title>\n<desc>{told}</desc>\n<style>{_STYLE}</style>\n"
        f"{body}\n</svg>\n"
    )


def _size(graph: PolicyGraph, decision: Decision) -> Size:
    lines = facts(graph, decision)
    wide = max(
        width(decision.state),
        text_width(decision.action or ""),
        *(text_width(line, _SMALL) for line in lines),
    )
    loop = 2 * _LOOP if _loop(graph, decision) else 0
    named = LINE + 2 if decision.action else 0
    rim = 2 * _rim(graph, decision)
    tall = EDGE + named + len(lines) * (LINE - 3) + 2 * _PAD
    return Size(wide + 2 * _PAD + loop + rim, tall + rim)


def _rim(graph: PolicyGraph, decision: Decision) -> int:
    return _RIM if decision.end > graph.above else 0


def _loop(graph: PolicyGraph, decision: Decision) -> Arc | None:
    """The arc that leads from a state to itself."""
    own = (arc for arc in graph.arcs if arc.source == arc.target == decision.state)
    return next(own, None)


def _node(
    graph: PolicyGraph, decision: Decision, layout: Layout, sizes: dict[str, Size]
) -> Iterator[str]:
    x, y = layout.centers[decision.state]
    loop, size, rim = _loop(graph, decision), sizes[decision.state], _rim(graph, decision)
    wide, tall = size.width - (2 * _LOOP if loop else 0), size.height
    outer, top = y - tall / 2, y - tall / 2 + rim
    yield f"<g><title>{escape(sentence(graph, decision))}</title>"
    if rim:
        kind = "ending rewarded" if decision.state in graph.rewarded else "ending"
        yield rectangle(kind, x - wide / 2, outer, wide, tall, 10)
    yield rectangle("node", x - wide / 2 + rim, top, wide - 2 * rim, tall - 2 * rim, 7)
    left = x - width(decision.state) / 2
    yield from pictograms(decision.state, graph.members, graph.programs, left, top + _PAD)
    below = top + _PAD + EDGE + LINE / 2 + 3
    if decision.action:
        yield text(decision.action, x, below, "action")
        below += LINE - 1
    for line in facts(graph, decision):
        yield text(line, x, below, "fact")
        below += LINE - 3
    if decision.started:
        yield f'<circle class="tip" cx="{x:.1f}" cy="{outer - _START + 4:.1f}" r="4"/>'
        yield from _arrow((x, outer - _START + 4), (x, outer), 1.5)
    if loop is not None:
        yield from _looped(loop, x + wide / 2, y)
    yield "</g>"


def _arrow(start: Point, end: Point, thickness: float) -> Iterator[str]:
    """A straight arrow downwards."""
    yield (
        f'<path class="arc" d="M{start[0]:.1f} {start[1]:.1f}V{end[1] - _HEAD + 1:.1f}" '
        f'stroke-width="{thickness}"/>'
    )
    yield _tip(end, down=True)


def _tip(end: Point, down: bool) -> str:
    back = -_HEAD if down else _HEAD
    return f'<path class="tip" d="M{end[0]:.1f} {end[1]:.1f}l-4.5 {back}h9z"/>'


def _looped(arc: Arc, x: float, y: float) -> Iterator[str]:
    yield (
        f'<path class="arc" d="M{x:.1f} {y - 9:.1f}c24 -14 24 32 {_HEAD - 1:.1f} 20" '
        f'stroke-width="{_thickness(arc):.1f}"/>'
    )
    yield f'<path class="tip" d="M{x:.1f} {y + 11:.1f}l9 -4.5v9z"/>'
    yield text(percent(arc.share), x + 38, y, "share")


def _arcs(graph: PolicyGraph, layout: Layout, sizes: dict[str, Size]) -> Iterator[str]:
    """The arcs, and then their labels, which nothing may hide."""
    labels: list[_Box] = []
    told = []
    for arc in graph.arcs:
        if arc.source == arc.target:
            continue
        path, points = _path(layout.routes[arc.source, arc.target])
        yield f'<path class="arc" d="{path}" stroke-width="{_thickness(arc):.1f}"/>'
        (_, before), end = points[-2], points[-1]
        yield _tip(end, down=end[1] > before)
        label = percent(arc.share)
        place = _label(points, text_width(label, _SMALL), labels, layout, sizes)
        labels.append(place)
        told.append(_ground(place) + text(label, place.x, place.y, "share"))
    yield from told


def _ground(label: _Box) -> str:
    wide, tall = label.width - 2, _SMALL + 2
    return rectangle("ground", label.x - wide / 2, label.y - tall / 2, wide, tall, 2)


def _thickness(arc: Arc) -> float:
    return 0.8 + 2.2 * arc.share


def _path(route: Sequence[Point]) -> tuple[str, list[Point]]:
    """A route as a smooth path that begins and ends vertically, and points along it."""
    if len(route) == 3:  # within a row: one bow
        (x1, y1), (_, y), (x2, y2) = route
        bows = [((x1, y1), (x1, 2 * y - y1), (x2, 2 * y - y1), (x2, y2))]
    else:
        bows = [
            ((x1, y1), (x1, (y1 + y2) / 2), (x2, (y1 + y2) / 2), (x2, y2))
            for (x1, y1), (x2, y2) in pairwise(route)
        ]
    points = [_on(bow, step / 16) for bow in bows for step in range(17)]
    start, control, approach, end = bows[-1]
    back = _HEAD - 1 if approach[1] < end[1] else 1 - _HEAD
    bows[-1] = (start, control, approach, (end[0], end[1] - back))
    first = bows[0][0]
    drawn = "".join(
        "C" + " ".join(f"{x:.1f} {y:.1f}" for x, y in bow[1:]) for bow in bows
    )  # fmt: skip
    return f"M{first[0]:.1f} {first[1]:.1f}{drawn}", points


def _on(bow: Sequence[Point], t: float) -> Point:
    """A point on a cubic Bezier curve, ``t`` from 0 to 1."""
    weights = ((1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3)
    x = sum(weight * point[0] for weight, point in zip(weights, bow, strict=True))
    y = sum(weight * point[1] for weight, point in zip(weights, bow, strict=True))
    return x, y


def _label(
    points: Sequence[Point],
    wide: float,
    taken: Sequence[_Box],
    layout: Layout,
    sizes: dict[str, Size],
) -> _Box:
    """Where along an arc its label meets no other label and no node, near its first third."""
    places = sorted(range(len(points)), key=lambda place: abs(place - len(points) // 3))
    boxes = [_Box(*points[place], wide) for place in places]
    nodes = [(*layout.centers[state], *size) for state, size in sizes.items()]

    def hidden(box: _Box) -> bool:
        return any(
            abs(box.x - x) < (w + wide) / 2 and abs(box.y - y) < (h + _SMALL) / 2 + 3
            for x, y, w, h in nodes
        )

    free = (box for box in boxes if not hidden(box) and not any(map(box.meets, taken)))
    return next(free, boxes[0])


def _columns(wide: float) -> int:
    """How many entries of the legend fit beside each other."""
    return next(columns for columns in (5, 4, 2, 1) if columns * _entry() <= wide or columns == 1)


def _entry() -> float:
    return PITCH + max(text_width(letter.meaning, _SMALL) for letter in LETTERS.values()) + 8


def _letters(graph: PolicyGraph) -> list[str]:
    """The letters of the legend: ``*`` only where it is used."""
    return [
        letter for letter in LETTERS
        if letter != "*" or any("*" in decision.state for decision in graph.decisions)
    ]  # fmt: skip


def _note_lines(graph: PolicyGraph, wide: float) -> list[str]:
    room = int(wide / text_width("m", _SMALL))
    return [line for note in notes(graph) for line in wrap(note, room)]


def _legend_height(graph: PolicyGraph, wide: float) -> float:
    rows = -(-len(_letters(graph)) // _columns(wide))
    return rows * (EDGE + 6) + 6 + len(_note_lines(graph, wide)) * (LINE - 2) + _MARGIN / 2


def _legend(graph: PolicyGraph, left: float, top: float, wide: float) -> Iterator[str]:
    letters, columns = _letters(graph), _columns(wide)
    for number, letter in enumerate(letters):
        x = left + number % columns * _entry()
        y = top + number // columns * (EDGE + 6)
        yield pictogram(letter, False, x, y)
        yield text(LETTERS[letter].meaning, x + PITCH, y + EDGE / 2, "note")
    below = top + -(-len(letters) // columns) * (EDGE + 6) + 6 + LINE / 2
    for number, line in enumerate(_note_lines(graph, wide)):
        yield text(line, left, below + number * (LINE - 2), "note")

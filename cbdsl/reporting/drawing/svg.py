"""Graphs as pictures, laid out in columns: the state, its patterns, the actions that follow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple
from xml.sax.saxutils import escape, quoteattr

from cbdsl.reporting.drawing.graph import Box, Graph
from cbdsl.reporting.drawing.shapes import FONT, LINE, TIP, rectangle, text, text_width

_PAD = 10
_GAP = 14
_CORRIDOR = 56

_STYLE = """
  svg { background: #fff; font: %s; }
  text { fill: #1a1a1a; dominant-baseline: central; }
  .name { font-weight: bold; }
  .panel { fill: #f6f7f9; stroke: #c4c9d0; }
  .state { fill: #fff3d6; stroke: #a67c00; }
  .pattern { fill: #fff; stroke: #a67c00; }
  .action { fill: #e3eefb; stroke: #2f6db3; }
  .unused { fill: none; stroke: #8a94a0; stroke-dasharray: 5 4; }
  .reward { fill: #23762f; }
  .edge { fill: none; stroke: #555; }
  .back { fill: none; stroke: #8a94a0; stroke-dasharray: 5 4; }
"""


class _Columns(NamedTuple):
    """Where the columns of a panel begin, and how wide they are."""

    state: float
    state_width: float
    pattern: float
    pattern_width: float
    action: float
    action_width: float

    @property
    def end(self) -> float:
        return self.action + self.action_width


class _Row(NamedTuple):
    """An action and its patterns, or the end of the program, between two heights."""

    box: Box | None
    patterns: tuple[str, ...]
    top: float
    height: float

    @property
    def middle(self) -> float:
        return self.top + self.height / 2


def svg(graph: Graph) -> str:
    """A graph as SVG; the programs within it have panels below."""
    panels, top, width = [], float(_GAP), 0.0
    for inner in _all(graph, []):
        panel = _Panel(inner, top)
        panels.append(panel)
        top += panel.height + _GAP
        width = max(width, panel.width)
    size = f'width="{width + 2 * _GAP:.0f}" height="{top:.0f}"'
    box = f'viewBox="0 0 {width + 2 * _GAP:.0f} {top:.0f}"'
    body = "\n".join(line for panel in panels for line in panel.lines())
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {box} role="img">\n'
        f"<title>{escape(graph.name)}: states and actions</title>\n<style>{_STYLE % FONT}</style>\n"
        f"{TIP}\n{body}\n</svg>\n"
    )


def _all(graph: Graph, seen: list[Graph]) -> list[Graph]:
    """A graph and those within it, each once."""
    if graph not in seen:
        seen.append(graph)
        for box in graph.boxes:
            if box.inner is not None:
                _all(box.inner, seen)
    return seen


class _Panel:
    """One program, from ``top`` downwards."""

    def __init__(self, graph: Graph, top: float) -> None:
        self._graph = graph
        self._top = top
        self._rows = _rows(graph, top + 2 * _GAP + LINE)
        self._columns = _columns(graph, self._rows)
        last = self._rows[-1]
        self.height = last.top + last.height + 3 * _GAP - top
        self.width = max(self._columns.end + 2 * _GAP, text_width(self._title()) + 2 * _PAD)

    def _title(self) -> str:
        below = self._graph.background
        return self._graph.name if below is None else f"{self._graph.name}; below: {below}"

    def lines(self) -> Iterator[str]:
        name = quoteattr(self._graph.name)
        yield f"<g id={name}>"
        yield rectangle("panel", _GAP, self._top, self.width, self.height)
        yield text(self._title(), _GAP + _PAD, self._top + _GAP, "name")
        yield from self._state()
        for row in self._rows:
            yield from self._row(row)
        yield from self._back()
        yield "</g>"

    def _middle(self) -> float:
        """The height of the state: in the middle of what follows it."""
        last = [row for row in self._rows if row.patterns][-1:] or self._rows
        return (self._rows[0].top + last[-1].top + last[-1].height) / 2

    def _state(self) -> Iterator[str]:
        members = ("state of", *self._graph.members)
        height, columns = _height(members), self._columns
        top = self._middle() - height / 2
        yield rectangle("state", columns.state, top, columns.state_width, height, 8)
        yield from _lines(members, columns.state, top)

    def _row(self, row: _Row) -> Iterator[str]:
        columns = self._columns
        first = row.middle - (len(row.patterns) - 1) * (LINE + _GAP) / 2
        for number, pattern in enumerate(row.patterns):
            height = first + number * (LINE + _GAP)
            start = columns.state + columns.state_width
            yield _curve(start, self._middle(), columns.pattern, height)
            top, round_ = height - LINE / 2 - 3, LINE / 2 + 3
            yield rectangle(
                "pattern", columns.pattern, top, columns.pattern_width, LINE + 6, round_
            )
            yield text(pattern, columns.pattern + _PAD, height)
            yield _curve(
                columns.pattern + columns.pattern_width, height, columns.action, row.middle
            )
        yield from _end(columns, row) if row.box is None else _action(columns, row, row.box)

    def _back(self) -> Iterator[str]:
        """From the actions around the bottom to the state that they change."""
        used = [row.middle for row in self._rows if row.box is not None and row.patterns]
        if not used:
            return
        columns, x = self._columns, self._columns.end + _GAP
        bottom = self._top + self.height - _GAP
        for middle in used:
            yield f'<path class="back" d="M{columns.end:.1f} {middle:.1f}H{x:.1f}"/>'
        state = columns.state + columns.state_width / 2
        foot = self._middle() + _height(("", *self._graph.members)) / 2
        yield (
            f'<path class="back" marker-end="url(#tip)" '
            f'd="M{x:.1f} {min(used):.1f}V{bottom:.1f}H{state:.1f}V{foot:.1f}"/>'
        )


def _rows(graph: Graph, top: float) -> list[_Row]:
    """One below the other: actions that follow states, the program's end, and the others."""
    parts: list[tuple[Box | None, tuple[str, ...]]] = [(box, box.patterns) for box in graph.boxes]
    if graph.coverage.undecided:
        used = sum(bool(box.patterns) for box in graph.boxes)
        parts.insert(used, (None, ("any other",)))
    rows: list[_Row] = []
    for box, patterns in parts:
        own = _height(_text(box)) if box is not None else 2 * LINE
        height = max(own, len(patterns) * (LINE + _GAP))
        rows.append(_Row(box, patterns, top, height))
        top += height + _GAP
    return rows


def _columns(graph: Graph, rows: Sequence[_Row]) -> _Columns:
    state = _widest(("state of", *graph.members))
    patterns = _widest([pattern for row in rows for pattern in row.patterns])
    actions = _widest([line for row in rows if row.box is not None for line in _text(row.box)])
    left = 2.0 * _GAP
    pattern = left + state + _CORRIDOR
    return _Columns(left, state, pattern, patterns, pattern + patterns + _CORRIDOR, actions)


def _action(columns: _Columns, row: _Row, box: Box) -> Iterator[str]:
    height = _height(_text(box))
    top = row.middle - height / 2
    kind = "action" if box.patterns else "unused"
    if box.inner is not None:
        yield f"<a href={quoteattr('#' + box.inner.name)}>"
    yield rectangle(kind, columns.action, top, columns.action_width, height, 3)
    yield from _lines(_text(box), columns.action, top, "name", box.rewarded)
    if box.inner is not None:
        yield "</a>"


def _end(columns: _Columns, row: _Row) -> Iterator[str]:
    x, y = columns.action + LINE / 2, row.middle
    yield f'<circle class="pattern" cx="{x:.1f}" cy="{y:.1f}" r="{LINE / 2}"/>'
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{LINE / 3:.1f}"/>'
    yield text("the program ends", x + LINE, y)


def _text(box: Box) -> tuple[str, ...]:
    return (box.name, *box.lines, *(("can be rewarded",) if box.rewarded else ()))


def _widest(lines: Sequence[str]) -> float:
    return max((text_width(line) for line in lines), default=0.0) + 2 * _PAD


def _height(lines: Sequence[str]) -> float:
    return len(lines) * LINE + _PAD


def _lines(
    lines: Sequence[str], left: float, top: float, first: str = "", rewarded: bool = False
) -> Iterator[str]:
    for place, line in enumerate(lines):
        last = rewarded and place == len(lines) - 1
        kind = "reward" if last else first if place == 0 else ""
        yield text(line, left + _PAD, top + _PAD / 2 + (place + 0.5) * LINE, kind)


def _curve(x1: float, y1: float, x2: float, y2: float) -> str:
    middle = (x1 + x2) / 2
    bend = f"C{middle:.1f} {y1:.1f} {middle:.1f} {y2:.1f} {x2:.1f} {y2:.1f}"
    return f'<path class="edge" marker-end="url(#tip)" d="M{x1:.1f} {y1:.1f}{bend}"/>'

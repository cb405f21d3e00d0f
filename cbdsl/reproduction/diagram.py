"""Transition diagrams as pictures: states in columns by how soon they can be reached."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

from cbdsl.reproduction.arcs import Arc

# In px.
_COLUMN, _ROW, _RADIUS, _MARGIN, _TOP, _LINE, _GAP = 300, 130, 22, 60, 110, 14, 6
# How far an arc bends to its left, as a share of its length, so that there is room for one back;
# one that leads further than to the next column bends around what is there.
_BEND, _LONG_BEND = 0.12, 0.24
# Where along an arc its label is: nearer to its beginning, away from that of an arc that crosses.
_ALONG = 0.3
_INK, _PEN = "#222222", "#0072b2"

Point = tuple[float, float]


@dataclass(frozen=True)
class Diagram:
    """States, and what leads from one to another.

    Attributes:
        name: of its file, without suffix.
        title: what it shows.
        start: the state that episodes begin in.
        arcs: each with its share of what leaves its state.
    """

    name: str
    title: str
    start: str
    arcs: Mapping[Arc, float]

    def data(self) -> dict[str, object]:
        """What it shows, for scripts."""
        return {"arcs": [[*arc, round(share, 4)] for arc, share in self.arcs.items()]}

    def svg(self) -> str:
        """The picture, as the text of an SVG file."""
        places = self._places()
        width = max(x for x, _ in places.values()) + _MARGIN
        height = max(y for _, y in places.values()) + _TOP - 20
        labels = self._labels()
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
            f'font-family="sans-serif" font-size="12">',
            f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>',
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" '
            f'markerHeight="8" orient="auto"><path d="M0 0L8 4L0 8z" fill="{_PEN}"/>'
            "</marker></defs>",
            f'<text x="16" y="22" font-weight="bold" fill="{_INK}">{escape(self.title)}</text>',
        ]
        parts += [_arc(places[state], places[next_state]) for state, next_state in labels]
        parts += [part for state, place in places.items() for part in _node(state, place)]
        # On top, since a long arc may lead past a state.
        for (state, next_state), lines in labels.items():
            parts += _label(places[state], places[next_state], lines)
        return "\n".join([*parts, "</svg>", ""])

    def _labels(self) -> dict[tuple[str, str], list[str]]:
        """What is written at the arcs, by where they begin and end."""
        found: dict[tuple[str, str], list[str]] = {}
        for arc, share in self.arcs.items():
            label = f"{arc.action} {100 * share:.0f} %"
            found.setdefault((arc.state, arc.next_state), []).append(label)
        return found

    def _places(self) -> dict[str, Point]:
        """The middle of each state."""
        columns = self._columns()
        tallest = max(len(column) for column in columns)
        return {
            state: (
                _MARGIN + _COLUMN * across,
                _TOP + _ROW * (down + (tallest - len(column)) / 2),
            )
            for across, column in enumerate(columns)
            for down, state in enumerate(column)
        }

    def _columns(self) -> list[list[str]]:
        """States by the number of arcs from the start; those that cannot be reached come last."""
        columns, known = [[self.start]], {self.start}
        while True:
            reached = dict.fromkeys(
                arc.next_state
                for state in columns[-1]
                for arc in self.arcs
                if arc.state == state and arc.next_state not in known
            )
            if not reached:
                break
            known.update(reached)
            columns.append(list(reached))
        ends = (state for arc in self.arcs for state in (arc.state, arc.next_state))
        others = [state for state in dict.fromkeys(ends) if state not in known]
        return [*columns, others] if others else columns


def _node(state: str, place: Point) -> Iterator[str]:
    x, y = place
    yield f'<circle cx="{x:g}" cy="{y:g}" r="{_RADIUS}" fill="#ffffff" stroke="{_INK}"/>'
    yield _text(
        x, y + 4, state.replace("-", "\N{EN DASH}"), 'text-anchor="middle" font-weight="bold"'
    )


def _arc(start: Point, end: Point) -> str:
    if start == end:
        x, y = start
        first, last = _rim(start, (x - 20, y - 60)), _rim(start, (x + 20, y - 60))
        return _path(f"M{_xy(first)}C{_xy((x - 24, y - 62))} {_xy((x + 24, y - 62))} {_xy(last)}")
    control, _ = _bent(start, end)
    first, last = _rim(start, control), _rim(end, control)
    return _path(f"M{_xy(first)}Q{_xy(control)} {_xy(last)}")


def _bent(start: Point, end: Point) -> tuple[Point, Point]:
    """Control point of an arc, and the direction to its left, where it bends."""
    (x1, y1), (x2, y2) = start, end
    length = math.hypot(x2 - x1, y2 - y1)
    # y points down.
    left = ((y2 - y1) / length, -(x2 - x1) / length)
    bend = 2 * (_BEND if abs(x2 - x1) <= _COLUMN else _LONG_BEND) * length
    return ((x1 + x2) / 2 + bend * left[0], (y1 + y2) / 2 + bend * left[1]), left


def _rim(centre: Point, towards: Point) -> Point:
    """Where the way from a state's middle leaves its circle."""
    dx, dy = towards[0] - centre[0], towards[1] - centre[1]
    length = math.hypot(dx, dy)
    return centre[0] + _RADIUS * dx / length, centre[1] + _RADIUS * dy / length


def _path(way: str) -> str:
    return (
        f'<path d="{way}" fill="none" stroke="{_PEN}" stroke-width="1.5" marker-end="url(#tip)"/>'
    )


def _label(start: Point, end: Point, lines: list[str]) -> Iterator[str]:
    """Lines beside an arc, on its outer side."""
    if start == end:
        place, outwards = (start[0], start[1] - 54), (0.0, -1.0)
    else:
        control, outwards = _bent(start, end)
        place = _along(start, control, end)
    across, down = outwards
    anchor = "middle" if abs(across) < abs(down) else "start" if across > 0 else "end"
    # The block of lines begins where the arc is, and ends away from it.
    first = place[1] + _LINE * ((down - 1) / 2 * (len(lines) - 1)) + (_GAP + 4) * down + 4
    for index, line in enumerate(lines):
        style = f'text-anchor="{anchor}" stroke="#ffffff" stroke-width="4" paint-order="stroke"'
        yield _text(place[0] + _GAP * across, first + _LINE * index, line, style)


def _along(start: Point, control: Point, end: Point) -> Point:
    """Where an arc's label is."""
    shares = ((1 - _ALONG) ** 2, 2 * _ALONG * (1 - _ALONG), _ALONG**2)
    points = (start, control, end)
    return (
        sum(share * x for share, (x, _) in zip(shares, points, strict=True)),
        sum(share * y for share, (_, y) in zip(shares, points, strict=True)),
    )


def _text(x: float, y: float, text: str, style: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{_INK}" {style}>{escape(text)}</text>'


def _xy(point: Point) -> str:
    return f"{point[0]:.1f},{point[1]:.1f}"

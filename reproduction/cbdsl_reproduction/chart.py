"""Chart of the curves of an experiment, and its picture as SVG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

_WIDTH, _HEIGHT = 610, 300
# The right margin fits a line's name of 30 characters.
_LEFT, _RIGHT, _TOP, _BOTTOM = 70, 200, 34, 46
# Distinguishable without colour vision (Okabe and Ito), and by dashes in print.
_STYLES = (("#0072b2", ""), ("#d55e00", "7 3"), ("#009e73", "2 3"), ("#cc79a7", "9 3 2 3"))
_TICKS = 5


@dataclass(frozen=True)
class Line:
    """Curve of a chart.

    Attributes:
        name: Name of the curve.
        x, y: Abscissas and ordinates, of equal number.
        low, high: Ends of intervals around the ordinates, of the same number, or empty.
    """

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()


@dataclass(frozen=True)
class Chart:
    """Curves over a common axis.

    Attributes:
        name: Name of its file, without suffix.
        title: Title of the chart.
        x_label, y_label: Labels of the axes, with units.
        lines: Curves, at most four.
    """

    name: str
    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]

    def data(self) -> dict[str, object]:
        """Return the data of the chart, for scripts."""
        return {
            "x": self.x_label,
            "y": self.y_label,
            "lines": {line.name: [list(line.x), list(line.y)] for line in self.lines},
        }

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        horizontal = _ChartAxis([x for line in self.lines for x in line.x], _LEFT, _WIDTH - _RIGHT)
        vertical = _ChartAxis(
            [y for line in self.lines for y in (*line.y, *line.low, *line.high)],
            _HEIGHT - _BOTTOM,
            _TOP,
        )
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" '
            f'font-family="sans-serif" font-size="12">',
            f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#ffffff"/>',
            _text(_LEFT, 20, self.title, weight="bold"),
            _text((_LEFT + _WIDTH - _RIGHT) / 2, _HEIGHT - 8, self.x_label, "middle"),
            f'<g transform="rotate(-90 14 {(_TOP + _HEIGHT - _BOTTOM) / 2:g})">'
            + _text(14, (_TOP + _HEIGHT - _BOTTOM) / 2, self.y_label, "middle")
            + "</g>",
            *(_grid_across(at, label) for at, label in vertical.ticks()),
            *(_grid_up(at, label) for at, label in horizontal.ticks()),
        ]
        # Bands are drawn first, so that they do not hide curves.
        parts += [
            _band(line, horizontal, vertical, color)
            for line, (color, _) in zip(self.lines, _STYLES, strict=False)
            if line.low
        ]
        for index, (line, style) in enumerate(zip(self.lines, _STYLES, strict=False)):
            points = " ".join(
                f"{horizontal(x):.1f},{vertical(y):.1f}"
                for x, y in zip(line.x, line.y, strict=True)
            )
            parts += _drawn(line.name, points, style, _TOP + 10 + 20 * index)
        return "\n".join([*parts, "</svg>", ""])


class _ChartAxis:
    """Mapping of values to pixels between round numbers."""

    def __init__(self, values: Sequence[float], start: float, end: float) -> None:
        low, high = min(values), max(values)
        self._step = _round_step((high - low) or abs(high) or 1.0)
        self._low = math.floor(low / self._step + 1e-9) * self._step
        self._count = max(1, math.ceil((high - self._low) / self._step - 1e-9))
        self._start, self._pixels = start, (end - start) / (self._count * self._step)

    def __call__(self, value: float) -> float:
        return self._start + (value - self._low) * self._pixels

    def ticks(self) -> list[tuple[float, str]]:
        """Return the pixel positions and labels of the round numbers."""
        values = [self._low + index * self._step for index in range(self._count + 1)]
        return [(self(value), f"{round(value / self._step) * self._step:.6g}") for value in values]


def _round_step(span: float) -> float:
    """Return 1, 2 or 5 times a power of ten, so that about five steps cover the span."""
    rough = span / _TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * 0.999)


def _text(x: float, y: float, text: str, anchor: str = "start", weight: str = "normal") -> str:
    return (
        f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-weight="{weight}" '
        f'fill="#222222">{escape(text)}</text>'
    )


def _grid_across(y: float, label: str) -> str:
    line = f'<path d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}" stroke="#dddddd"/>'
    return line + _text(_LEFT - 6, round(y + 4, 1), label, "end")


def _grid_up(x: float, label: str) -> str:
    line = f'<path d="M{x:.1f} {_HEIGHT - _BOTTOM}v5" stroke="#888888"/>'
    return line + _text(round(x, 1), _HEIGHT - _BOTTOM + 18, label, "middle")


def _band(line: Line, horizontal: _ChartAxis, vertical: _ChartAxis, color: str) -> str:
    """Return the interval around a curve as a polygon along its upper and lower ends."""
    there = zip(line.x, line.high, strict=True)
    back = reversed(list(zip(line.x, line.low, strict=True)))
    corners = " ".join(f"{horizontal(x):.1f},{vertical(y):.1f}" for x, y in (*there, *back))
    return f'<polygon points="{corners}" fill="{color}" fill-opacity="0.15"/>'


def _drawn(name: str, points: str, style: tuple[str, str], y: float) -> list[str]:
    color, dashes = style
    pen = f'fill="none" stroke="{color}" stroke-width="2" stroke-dasharray="{dashes or "none"}"'
    x = _WIDTH - _RIGHT + 12
    return [
        f'<polyline points="{points}" {pen}/>',
        f'<path d="M{x} {y - 4:g}h24" {pen}/>',
        _text(x + 30, y, name),
    ]

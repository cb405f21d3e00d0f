"""Bar chart as SVG, with bars of one or two parts, such as counts of actions and rewards."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import NamedTuple

_WIDTH, _ROW, _LEFT, _TOP, _RIGHT = 610, 30, 170, 54, 120
_FULL, _REST, _INK = "#0072b2", "#b5e0cf", "#222222"


class Bar(NamedTuple):
    """Bar of a chart.

    Attributes:
        name: Label of the bar.
        first: Length of its first part.
        second: Length of its second part.
    """

    name: str
    first: float
    second: float = 0.0


@dataclass(frozen=True)
class BarChart:
    """Bars over a common axis.

    Attributes:
        name: Name of its file, without suffix.
        title: Title of the chart.
        bars: Bars from top to bottom.
        first, second: Labels of the parts; an empty label means that there is no second part.
    """

    name: str
    title: str
    bars: tuple[Bar, ...]
    first: str
    second: str = ""

    def data(self) -> dict[str, object]:
        """Return the data of the chart, for scripts."""
        kinds = [self.first, self.second] if self.second else [self.first]
        return {bar.name: dict(zip(kinds, bar[1:], strict=False)) for bar in self.bars}

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        longest = max((bar.first + bar.second for bar in self.bars), default=1.0) or 1.0
        scale, height = (_WIDTH - _LEFT - _RIGHT) / longest, _TOP + _ROW * len(self.bars) + 10
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" '
            f'font-family="sans-serif" font-size="12">',
            f'<rect width="{_WIDTH}" height="{height}" fill="#ffffff"/>',
            _text(20, 20, self.title, weight="bold"),
            f'<rect x="20" y="32" width="12" height="12" fill="{_FULL}"/>',
            _text(38, 42, self.first),
        ]
        if self.second:
            parts += [
                f'<rect x="150" y="32" width="12" height="12" fill="{_REST}"/>',
                _text(168, 42, self.second),
            ]
        for row, bar in enumerate(self.bars):
            label = f"{bar.first:.3g} + {bar.second:.3g}" if self.second else f"{bar.first:.3g}"
            parts += _drawn(bar, label, _TOP + row * _ROW, scale)
        return "\n".join([*parts, "</svg>", ""])


def _drawn(bar: Bar, label: str, y: float, scale: float) -> list[str]:
    first, second = bar.first * scale, bar.second * scale
    return [
        _text(_LEFT - 8, y + 18, bar.name, "end"),
        f'<rect x="{_LEFT}" y="{y + 4}" width="{first:.1f}" height="20" fill="{_FULL}"/>',
        f'<rect x="{_LEFT + first:.1f}" y="{y + 4}" width="{second:.1f}" height="20" '
        f'fill="{_REST}"/>',
        _text(_LEFT + first + second + 6, y + 18, label),
    ]


def _text(x: float, y: float, text: str, anchor: str = "start", weight: str = "normal") -> str:
    return (
        f'<text x="{x:.1f}" y="{y:g}" text-anchor="{anchor}" font-weight="{weight}" '
        f'fill="{_INK}">{escape(text)}</text>'
    )

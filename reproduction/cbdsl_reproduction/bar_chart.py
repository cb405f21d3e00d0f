"""Bar chart as SVG, with bars of one or two parts, such as counts of actions and rewards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from cbdsl_reproduction.figure import BLUE, drawing

_REST = "#b5e0cf"


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
        names = [bar.name for bar in self.bars]
        first, second = [bar.first for bar in self.bars], [bar.second for bar in self.bars]
        with drawing(6.4, 0.9 + 0.3 * len(self.bars), self.title) as draft:
            rows = range(len(self.bars))
            draft.axes.barh(rows, first, color=BLUE, label=self.first)
            if self.second:
                draft.axes.barh(rows, second, left=first, color=_REST, label=self.second)
            for row, bar in enumerate(self.bars):
                text = f"{bar.first:.3g} + {bar.second:.3g}" if self.second else f"{bar.first:.3g}"
                draft.axes.text(bar.first + bar.second, row, f" {text}", va="center")
            draft.axes.set_yticks(rows, names, parse_math=False)
            draft.axes.invert_yaxis()
            draft.axes.margins(x=0.15)
            draft.figure.legend(loc="outside lower left", ncols=2)
        return draft.svg

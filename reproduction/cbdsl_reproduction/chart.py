"""Chart of the curves of an experiment, and its picture as SVG."""

from __future__ import annotations

from dataclasses import dataclass

from cbdsl_reproduction.figure import BLUE, GREEN, PURPLE, VERMILION, drawing

# Colours, and dashes in print.
_STYLES = ((BLUE, "-"), (VERMILION, "--"), (GREEN, ":"), (PURPLE, "-."))


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
        with drawing(6.4, 3.1, self.title) as draft:
            for line, (color, dashes) in zip(self.lines, _STYLES, strict=False):
                (curve,) = draft.axes.plot(
                    line.x, line.y, label=line.name, color=color, linestyle=dashes
                )
                curve.set_gid(f"curve {line.name}")
                if line.low:
                    band = draft.axes.fill_between(
                        line.x, line.low, line.high, color=color, alpha=0.15, linewidth=0
                    )
                    band.set_gid(f"interval {line.name}")
            draft.axes.set_xlabel(self.x_label, parse_math=False)
            draft.axes.set_ylabel(self.y_label, parse_math=False)
            draft.axes.grid(axis="y", color="#dddddd")
            legend = draft.figure.legend(loc="outside right upper")
            for entry in legend.get_texts():
                entry.set_parse_math(False)
        return draft.svg

"""Figures of matplotlib as SVG: equal data give equal text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import StringIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

#: Colours that are distinguishable without colour vision (Okabe and Ito).
BLUE, VERMILION, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#cc79a7"

_STYLE: Any = {
    "svg.fonttype": "none",  # text stays text
    # Without a fixed salt, matplotlib draws identifiers at random.
    "svg.hashsalt": "cbdsl",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.titlesize": "medium",
    "legend.frameon": False,
}


class Drawing:
    """Figure in progress.

    Args:
        figure: Figure of matplotlib.
        panels: Axes that hold the picture, row by row.

    Attributes:
        svg: Picture as the text of an SVG file, once it is complete.
    """

    def __init__(self, figure: Figure, panels: Sequence[Axes]) -> None:
        self.figure, self.panels = figure, panels
        self.svg = ""

    @property
    def axes(self) -> Axes:
        """First axes."""
        return self.panels[0]


def shade(
    axes: Axes,
    name: str,
    values: NDArray[np.float64],
    corner: Sequence[float],
    cell: Sequence[float],
    darkest: float,
    *,
    cmap: str,
) -> None:
    """Fill the cells of a grid by their values; masked ones stay empty.

    Args:
        axes: Axes to draw on.
        name: Identifier of the picture's element.
        values: Values of the cells, shape (columns, rows).
        corner: Position of the first cell's first corner, in data coordinates, shape (2,).
        cell: Width and height of a cell, shape (2,).
        darkest: Value of the darkest colour.
        cmap: Name of the colours, from light to dark.
    """
    (x, y), (wide, tall) = corner, cell
    columns, rows = values.shape
    extent = (x, x + columns * wide, y, y + rows * tall)
    # Without interpolation, each cell is a pixel of an embedded image.
    image = axes.imshow(
        values.T,
        cmap=cmap,
        vmin=0.0,
        vmax=darkest,
        extent=extent,
        origin="lower",
        interpolation="none",
    )
    image.set_gid(name)


@contextmanager
def drawing(
    width: float, height: float, title: str, *, rows: int = 1, columns: int = 1
) -> Iterator[Drawing]:
    """Provide axes to draw on; the picture is complete when the block ends.

    Args:
        width, height: Size of the figure, inches.
        title: Title of the axes, or of the figure if it has several panels.
        rows, columns: Numbers of panels.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
        draft = Drawing(figure, panels)
        if len(panels) == 1:
            draft.axes.set_title(title, parse_math=False)
        else:
            heading = figure.suptitle(title, x=0.01, ha="left", weight="bold", size="medium")
            heading.set_parse_math(False)
        yield draft
        text = StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    # Pages embed the picture, without the declaration of a document of its own.
    written = text.getvalue()
    draft.svg = written[written.index("<svg") :]

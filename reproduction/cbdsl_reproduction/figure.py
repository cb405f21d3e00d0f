"""Figures of matplotlib as SVG: equal data give equal text."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
        axes: Axes that hold the picture.

    Attributes:
        svg: Picture as the text of an SVG file, once it is complete.
    """

    def __init__(self, figure: Figure, axes: Axes) -> None:
        self.figure, self.axes = figure, axes
        self.svg = ""


@contextmanager
def drawing(width: float, height: float, title: str) -> Iterator[Drawing]:
    """Provide axes to draw on; the picture is complete when the block ends.

    Args:
        width, height: Size of the figure, inches.
        title: Title of the axes.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        draft = Drawing(figure, figure.add_subplot())
        draft.axes.set_title(title, parse_math=False)
        yield draft
        text = StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    # Pages embed the picture, without the declaration of a document of its own.
    written = text.getvalue()
    draft.svg = written[written.index("<svg") :]

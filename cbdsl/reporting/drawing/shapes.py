"""Text and rectangles of pictures of graphs."""

from __future__ import annotations

from xml.sax.saxutils import escape

#: Size of letters, px.
SIZE = 13
# A letter of the monospaced font is 0.6 times as wide as high; some fonts are a bit wider.
_LETTER = 0.64

#: The font, as CSS has it.
FONT = f'{SIZE}px "DejaVu Sans Mono", Menlo, Consolas, monospace'
#: Height of a line of text, px.
LINE = 18
#: Size of small letters, px.
SMALL = 11


def text_width(line: str, size: float = SIZE) -> float:
    """How wide a line is at most in a font of some size, px."""
    return len(line) * _LETTER * size


def text(line: str, x: float, y: float, kind: str = "") -> str:
    """A line of text, from ``x`` on, or around it where its class says so; ``y`` is its middle."""
    style = f' class="{kind}"' if kind else ""
    return f'<text{style} x="{x:.1f}" y="{y:.1f}">{escape(line)}</text>'


def rectangle(kind: str, x: float, y: float, width: float, height: float, round_: float = 4) -> str:
    """A rectangle with rounded corners, of the class ``kind``; ``x`` and ``y`` are upper left."""
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f'<rect class="{kind}" {place} rx="{round_:g}"/>'

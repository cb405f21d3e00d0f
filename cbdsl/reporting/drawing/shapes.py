"""Text and rectangles of pictures of graphs."""

from __future__ import annotations

from xml.sax.saxutils import escape

#: Size of letters, px.
SIZE = 13
# A letter of the monospaced font is 0.6 times as wide as high; some fonts are a bit wider.
_LETTER = 0.64

#: Font in CSS notation.
FONT = f'{SIZE}px "DejaVu Sans Mono", Menlo, Consolas, monospace'
#: Height of a line of text, px.
LINE = 18
#: Size of small letters, px.
SMALL = 11


def text_width(line: str, size: float = SIZE) -> float:
    """Return the maximum width of a line in a font of some size, px."""
    return len(line) * _LETTER * size


def text(line: str, x: float, y: float, kind: str = "") -> str:
    """Return a line of text with its middle at height ``y``.

    It begins at ``x``, or is centred there if its class says so.
    """
    style = f' class="{kind}"' if kind else ""
    return f'<text{style} x="{x:.1f}" y="{y:.1f}">{escape(line)}</text>'


def rectangle(kind: str, x: float, y: float, width: float, height: float, round_: float = 4) -> str:
    """Return a rectangle with rounded corners, of the class ``kind``.

    ``x`` and ``y`` are its upper left corner, px.
    """
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f'<rect class="{kind}" {place} rx="{round_:g}"/>'

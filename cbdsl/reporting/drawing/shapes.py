"""What pictures of graphs are made of: text, rectangles, the tips of arrows."""

from __future__ import annotations

from xml.sax.saxutils import escape

# In px. A letter of the monospaced font is 0.6 times as wide as high; some fonts are a bit wider.
_SIZE = 13
_LETTER = 0.64

#: The font, as CSS has it.
FONT = f'{_SIZE}px "DejaVu Sans Mono", Menlo, Consolas, monospace'
#: Height of a line of text, px.
LINE = 18

#: Defines the tip of an arrow, for ``marker-end="url(#tip)"``.
TIP = (
    '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" '
    'markerUnits="userSpaceOnUse" orient="auto"><path d="M0 0L8 4L0 8z" fill="#555"/></marker>'
    "</defs>"
)


def text_width(line: str, size: float = _SIZE) -> float:
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

"""Make the diagrams of docs/concepts.md.

Run ``python docs/make_diagrams.py`` after a change of the layers in pyproject.toml. It writes
docs/assets/loop.svg and docs/assets/layers.svg; equal input gives equal files.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
ASSETS = ROOT / "docs" / "assets"

_STYLE = """<style>
text { font: 14px system-ui, sans-serif; fill: #1b2733; text-anchor: middle }
.small { font-size: 12px; fill: #4d5b66 }
rect { fill: #eef2f5; stroke: #51718a; stroke-width: 1.5; rx: 6px }
.strong { fill: #d7e6f2 }
path { fill: none; stroke: #51718a; stroke-width: 1.8; marker-end: url(#head) }
</style>
<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4"
 markerWidth="7" markerHeight="7" orient="auto">
<polygon points="0 0 8 4 0 8" fill="#51718a"/></marker></defs>
"""
_PAPER = (
    '<rect x="0" y="0" width="100%" height="100%" style="fill: #ffffff; stroke: none; rx: 0px"/>\n'
)


def main() -> None:
    """Write both diagrams."""
    (ASSETS / "loop.svg").write_text(loop(), encoding="utf-8")
    (ASSETS / "layers.svg").write_text(layers(), encoding="utf-8")


def loop() -> str:
    """Return the diagram of documents, checked program, tick and knowledge."""
    parts = [
        _box(20, 40, 150, 76, "documents", "robot, program,", "stage: YAML"),
        _box(250, 40, 150, 76, "checked program", "types, casts, rows", "resolved"),
        _box(480, 40, 220, 190, "tick", "", "", strong=True),
        _box(500, 80, 180, 30, "observation → signals"),
        _box(500, 122, 180, 30, "controllers → law"),
        _box(500, 164, 180, 30, "predicates → policy"),
        '<text class="small" x="590" y="216">references → backend</text>',
        _box(250, 190, 150, 76, "diagnostics", "place, expected,", "remedy"),
        _box(480, 290, 220, 56, "transitions, recording", "one line per episode"),
        _box(20, 280, 250, 76, "knowledge", "policy, model, schema, catalog:", "YAML"),
        _arrow("M170 78 H248", 209, 66, "check"),
        _arrow("M400 78 H478", 439, 66, "run"),
        _arrow("M325 116 V188", 362, 158, "if errors"),
        _arrow("M590 230 V288", 626, 264, "record"),
        _arrow("M480 318 H272", 375, 308, "learn, explore"),
        _arrow("M95 280 V118", 132, 210, "validate"),
    ]
    return _svg(720, 370, parts)


def layers() -> str:
    """Return the diagram of the layers in pyproject.toml, top to bottom."""
    rows = _contract()
    parts = []
    for number, row in enumerate(rows):
        names = [name.strip(" ()") for name in row.split("|")]
        width = (660 - 10 * (len(names) - 1)) / len(names)
        for place, name in enumerate(names):
            x = 20 + place * (width + 10)
            parts.append(_box(x, 20 + 44 * number, width, 34, name, strong=number % 2 == 0))
    height = 44 * len(rows) + 50
    note = "a package imports only packages in rows below"
    parts.append(f'<text class="small" x="350" y="{height - 18}">{note}</text>')
    return _svg(700, height, parts)


def _contract() -> list[str]:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    found: list[str] = next(each["layers"] for each in contracts if each["type"] == "layers")
    return found


def _box(x: float, y: float, width: float, height: float, *lines: str, strong: bool = False) -> str:
    mark = ' class="strong"' if strong else ""
    shape = f'<rect{mark} x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"/>\n'
    middle = x + width / 2
    first = y + height / 2 + 5 - 9 * (len(lines) - 1)
    if strong and len(lines) > 1:
        first = y + 24
    texts = [
        f"<text{'' if number == 0 else ' class=' + chr(34) + 'small' + chr(34)} "
        f'x="{middle:g}" y="{first + 18 * number:g}">{line}</text>\n'
        for number, line in enumerate(lines)
        if line
    ]
    return shape + "".join(texts)


def _arrow(path: str, x: float, y: float, text: str) -> str:
    return f'<path d="{path}"/>\n<text class="small" x="{x:g}" y="{y:g}">{text}</text>\n'


def _svg(width: int, height: int, parts: list[str]) -> str:
    size = f'viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n'
    return head + _STYLE + _PAPER + "".join(parts) + "</svg>\n"


if __name__ == "__main__":
    main()

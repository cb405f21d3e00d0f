"""Map of the mounts that were tried: how far apart the hands end, by the way joint 1's axis points.

python -m cbdsl_reproduction.mounts.mount_map build/mounts.jsonl docs/assets/arm_mounts.svg
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path

from cbdsl_reproduction.mounts.mount_trial import GRASPS, PLACES, MountTrial
from cbdsl_reproduction.mounts.mounted_arms import TOGETHER
from cbdsl_reproduction.mounts.search_mounts import best_of, read

# Median distances of the tips below which a colour goes, m; legible without colour vision
# (ColorBrewer's YlGnBu, the nearest hands darkest).
_CLASSES = ((TOGETHER, "#081d58"), (0.3, "#225ea8"), (0.6, "#1d91c0"), (1.0, "#7fcdbb"))
_FARTHER = "#edf8b1"
_SIZE, _TOP, _BOTTOM = 300, 40, 50
_LEFTS = 70, 470
_WIDTH, _HEIGHT = 960, _TOP + _SIZE + _BOTTOM


def svg(done: Sequence[MountTrial]) -> str:
    """Return the map as the text of an SVG file: two panels and a legend."""
    best = best_of(done, 1)[0]
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" '
        f'font-family="sans-serif" font-size="12">',
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#ffffff"/>',
        *_directions(done, best),
        *_reaches(done, best),
        *_legend(),
        "</svg>",
        "",
    ]
    return "\n".join(parts)


def _directions(done: Sequence[MountTrial], best: MountTrial) -> Iterator[str]:
    def across(degrees: float) -> float:
        return _LEFTS[0] + (degrees + 90) / 180 * _SIZE

    def upward(degrees: float) -> float:
        return _TOP + (90 - degrees) / 180 * _SIZE

    def place(trial: MountTrial) -> tuple[float, float]:
        mount = trial.mount
        return across(math.degrees(mount["swing"])), upward(math.degrees(mount["lift"]))

    ticks = [(angle, f"{angle}°") for angle in (-90, -45, 0, 45, 90)]
    yield from _frame(
        _LEFTS[0], "Axis of joint 1", "from outward to forward", "above the horizontal plane",
        [(across(at), name) for at, name in ticks], [(upward(at), name) for at, name in ticks],
    )  # fmt: skip
    yield from _marks(done, best, place)


def _reaches(done: Sequence[MountTrial], best: MountTrial) -> Iterator[str]:
    def across(metres: float) -> float:
        return _LEFTS[1] + min(metres, 2.0) / 2.0 * _SIZE

    def upward(share: float) -> float:
        return _TOP + (1.0 - share) * _SIZE

    def place(trial: MountTrial) -> tuple[float, float]:
        return across(trial.distance), upward(trial.reach)

    yield from _frame(
        _LEFTS[1], "Hands and reach", "median distance of the palms' tips, m",
        f"share of {len(PLACES)} places reached",
        [(across(at), f"{at:g}") for at in (0, 0.5, 1.0, 1.5, 2.0)],
        [(upward(at), f"{100 * at:g} %") for at in (0, 0.25, 0.5, 0.75, 1.0)],
    )  # fmt: skip
    yield from _marks(done, best, place)


def _marks(
    done: Sequence[MountTrial],
    best: MountTrial,
    place: Callable[[MountTrial], tuple[float, float]],
) -> Iterator[str]:
    """Yield a dot for each mount that takes most places, the nearest hands on top."""
    shown = [trial for trial in done if 2 * len(trial.apart) > len(GRASPS)]
    for trial in sorted(shown, key=lambda trial: -trial.distance):
        x, y = place(trial)
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{_color(trial.distance)}"/>'
    for trial, name in ((done[0], "today's"), (best, "best")):
        x, y = place(trial)
        yield (
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="7" fill="none" stroke="#d55e00" '
            f'stroke-width="2"/>' + _label(x + 10, y + (14 if y < _TOP + 20 else -6), name)
        )


def _color(distance: float) -> str:
    return next((color for most, color in _CLASSES if distance < most), _FARTHER)


def _frame(
    left: float,
    title: str,
    below: str,
    beside: str,
    across: Sequence[tuple[float, str]],
    upward: Sequence[tuple[float, str]],
) -> Iterator[str]:
    middle = _TOP + _SIZE / 2
    yield (
        f'<rect x="{left}" y="{_TOP}" width="{_SIZE}" height="{_SIZE}" fill="#f4f4f4" '
        f'stroke="#888888"/>'
    )
    yield _label(left, _TOP - 14, title, weight="bold")
    yield _label(left + _SIZE / 2, _HEIGHT - 10, below, "middle")
    x = left - 48
    turned = _label(x, middle, beside, "middle")
    yield f'<g transform="rotate(-90 {x} {middle:g})">{turned}</g>'
    for x, name in across:
        yield _label(x, _TOP + _SIZE + 16, name, "middle")
    for y, name in upward:
        yield _label(left - 5, y + 4, name, "end")


def _legend() -> Iterator[str]:
    left = _LEFTS[1] + _SIZE + 20
    yield _label(left, _TOP + 10, "median distance")
    names = [f"below {100 * most:g} cm" for most, _ in _CLASSES] + ["farther"]
    colors = [color for _, color in _CLASSES] + [_FARTHER]
    for row, (name, color) in enumerate(zip(names, colors, strict=True)):
        y = _TOP + 32 + 20 * row
        yield f'<circle cx="{left + 5}" cy="{y - 4}" r="5" fill="{color}" stroke="#888888"/>'
        yield _label(left + 18, y, name)


def _label(x: float, y: float, text: str, anchor: str = "start", weight: str = "normal") -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-weight="{weight}" '
        f'fill="#222222">{escape(text, quote=False)}</text>'
    )


def main() -> None:
    """Draw it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path, help="rows of search_mounts.py")
    parser.add_argument("picture", type=Path, help="SVG file that is written")
    options = parser.parse_args()
    options.picture.write_text(svg(read(options.file)), encoding="utf-8")


if __name__ == "__main__":
    main()

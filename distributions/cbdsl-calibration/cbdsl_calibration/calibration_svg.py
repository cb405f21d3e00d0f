"""Picture of a calibration: errors of image points before and after, camera by camera, as SVG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from cbdsl.extend.backend import Floats

_PAD, _TITLE, _FOOT = 16, 46, 62
# Distinguishable without colour vision (Okabe and Ito).
_BEFORE, _AFTER, _INK, _FAINT = "#d55e00", "#0072b2", "#1d2126", "#5c656f"
# A typical error before calibration is drawn about so long, px of the image.
_LENGTH = 30.0


class CalibrationPanel(NamedTuple):
    """Image points of one camera.

    Attributes:
        camera: Name of the camera.
        size: Width and height of its image, px.
        points: Observed image points of the ball, px, shape (n, 2).
        before, after: Expected image points of the ball, px, shape (n, 2).
    """

    camera: str
    size: tuple[int, int]
    points: Floats
    before: Floats
    after: Floats


def calibration_svg(title: str, panels: Sequence[CalibrationPanel]) -> str:
    """Return a picture with a panel for each camera; the same panels give the same text.

    Lines lead from the observed to the expected image points, all lengthened by the same factor.

    Args:
        title: Title of the picture.
        panels: Panels, at least one.
    """
    times = _magnification(panels)
    width = sum(panel.size[0] for panel in panels) + _PAD * (len(panels) + 1)
    height = max(panel.size[1] for panel in panels) + _TITLE + _FOOT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'font-family="sans-serif" font-size="12" role="img" aria-label="{escape(title)}">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        _text(_PAD, 22, title, weight="bold"),
    ]
    left = _PAD
    for panel in panels:
        parts += _panel(panel, left, times)
        left += panel.size[0] + _PAD
    legend = f"lines from seen to expected image points, {times:g} times as long"
    parts.append(_text(_PAD, height - 10, legend, _FAINT))
    return "\n".join([*parts, "</svg>", ""])


def _magnification(panels: Sequence[CalibrationPanel]) -> float:
    """Return 1, 2 or 5 times a power of ten that makes lines visible within the images."""
    lengths = [np.linalg.norm(panel.before - panel.points, axis=1) for panel in panels]
    # The median prevents one outlier from making all other lines invisible. The bound avoids a
    # division by zero for cameras without errors.
    typical = max(float(np.median(np.concatenate(lengths))), 1e-3)
    # Long errors are never shortened: a camera that is off by 60 px is drawn to scale.
    rough = max(_LENGTH / typical, 1.0)
    power = 10.0 ** math.floor(math.log10(rough))
    return next(factor * power for factor in (5, 2, 1) if factor * power <= rough * 1.001)


def _panel(panel: CalibrationPanel, left: float, times: float) -> list[str]:
    width, height = panel.size
    # Lengthened lines may leave their image. The clip path keeps them out of the neighbouring
    # panel.
    clip = f"image-{escape(panel.camera)}"
    lines = [
        _lines(panel.points, expected, color, times)
        for expected, color in ((panel.before, _BEFORE), (panel.after, _AFTER))
    ]
    below = _TITLE + height
    return [
        _text(left, _TITLE - 6, f"camera {panel.camera}, {len(panel.points)} views", _FAINT),
        f'<clipPath id="{clip}"><rect width="{width}" height="{height}"/></clipPath>',
        f'<g transform="translate({left:g} {_TITLE})">',
        f'<rect width="{width}" height="{height}" fill="none" stroke="#8a94a0"/>',
        f'<g clip-path="url(#{clip})">{"".join(lines)}</g></g>',
        _text(left, below + 16, f"before: {_error(panel, panel.before):.2f} px", _BEFORE, "bold"),
        _text(left, below + 32, f"after: {_error(panel, panel.after):.2f} px", _AFTER, "bold"),
    ]


def _lines(points: Floats, expected: Floats, color: str, times: float) -> str:
    ends = points + times * (expected - points)
    path = "".join(
        f"M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}" for (x, y), (u, v) in zip(points, ends, strict=True)
    )
    return f'<path d="{path}" fill="none" stroke="{color}" stroke-width="1.3"/>'


def _error(panel: CalibrationPanel, expected: Floats) -> float:
    """Return the root mean square distance, px."""
    return float(np.sqrt(np.mean(np.sum((panel.points - expected) ** 2, axis=1))))


def _text(x: float, y: float, text: str, color: str = _INK, weight: str = "normal") -> str:
    return f'<text x="{x:g}" y="{y:g}" font-weight="{weight}" fill="{color}">{escape(text)}</text>'

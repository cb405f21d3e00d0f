"""Pictures of internal models: a map for two joints, else a curve for each joint."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from typing import Any, NamedTuple
from xml.sax.saxutils import escape

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import Floats
from cbdsl_report.landscape import Landscape
from cbdsl_report.learned_files import InternalModel, Joint

_PLOT = 360.0
_TALLEST, _LOWEST = 300.0, 120.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 54.0, 86.0, 10.0, 42.0
_CURVE_WIDTH, _CURVE_HEIGHT = 300.0, 130.0
# Candidate distances between ticks, degrees and mm, followed by those of densities.
_STEPS = {"rad": (5, 10, 15, 30, 45, 90), "m": (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)}
#: Shown units of positions by SI unit: factor, name, and sign behind a number.
SHOWN = {"rad": (math.degrees(1.0), "degrees", "°"), "m": (1000.0, "mm", " mm")}
_HEIGHTS = [first * 10.0**power for power in range(-1, 9) for first in (1, 2, 5)]
_TIMES = "\N{MULTIPLICATION SIGN}"


class _Axis(NamedTuple):
    """Axis of a joint's positions along one side of a plot, from ``start`` to ``end``, px."""

    joint: Joint
    start: float
    end: float

    def __call__(self, position: Any) -> Any:
        """Return the place, px, of a joint's position, rad or m, or of an array of positions."""
        lower, upper = self.joint.lower, self.joint.upper
        return self.start + (position - lower) / (upper - lower) * (self.end - self.start)

    @property
    def label(self) -> str:
        """Name of the joint with the shown unit."""
        return f"{self.joint.name}, {SHOWN[self.joint.unit][1]}"

    def ticks(self, room: float) -> Iterator[tuple[str, float]]:
        """Yield round positions in the shown unit and their places, ``room`` px apart or more."""
        factor, steps = SHOWN[self.joint.unit][0], _STEPS[self.joint.unit]
        lower, upper = factor * self.joint.lower, factor * self.joint.upper
        most = abs(self.end - self.start) / room
        # The longest step is the last resort. A slide of 20 m, for example, has ticks that are
        # closer than `room`.
        step = next((s for s in steps if (upper - lower) / s <= most), steps[-1])
        for number in range(math.ceil(lower / step), math.floor(upper / step) + 1):
            shown = number * step
            yield str(shown).replace("-", "\N{MINUS SIGN}"), self(shown / factor)


def density_svgs(model: InternalModel) -> list[str]:
    """Return the pictures of an internal model, each as SVG with a text alternative."""
    landscape = Landscape(model)
    # A joint without limits is drawn over one turn.
    bounds = zip(model.joints, landscape.lower, landscape.upper, strict=True)
    shown = (joint._replace(lower=lower, upper=upper) for joint, lower, upper in bounds)
    model = model._replace(joints=tuple(shown))
    if len(model.joints) == 2:
        return [_map(model, landscape)]
    return [_curve(joint, place, landscape) for place, joint in enumerate(model.joints)]


def _map(model: InternalModel, landscape: Landscape) -> str:
    """Draw two joints on two axes, with the same scale in px per degree if it fits."""
    first, second = model.joints
    ratio = (second.upper - second.lower) / (first.upper - first.lower)
    tall = min(_TALLEST, max(_LOWEST, _PLOT * ratio))
    across, up = _Axis(first, _LEFT, _LEFT + _PLOT), _Axis(second, _TOP + tall, _TOP)
    values = landscape.over(landscape.angles(0), landscape.angles(1))
    (x, y), peak = landscape.peak()
    # A density without mass within the limits has the peak 0, and would otherwise give 0 / 0.
    most = max(peak, np.finfo(float).tiny)
    where = f"{first.name} {_shown(x, first)}, {second.name} {_shown(y, second)}"
    area = f'x="{_LEFT}" y="{_TOP}" width="{_PLOT}" height="{tall:.1f}"'
    # Images count rows downwards, and the axis of the second joint points upwards.
    picture = _image(values[::-1] / most)
    parts = [
        f'<image {area} preserveAspectRatio="none" href="{picture}"/>',
        *(
            f'<circle class="sample" cx="{across(x):.1f}" cy="{up(y):.1f}" r="1.6"/>'
            for x, y in landscape.centers
        ),
        f'<rect class="frame" {area}/>',
        *_axis_across(across, up.start),
        *_axis_up(up, across.start),
        *_scale(most, across.end + 18, tall),
    ]
    title = f"Density of {first.name} and {second.name}"
    size = (across.end + _RIGHT, up.start + _BOTTOM)
    return _svg(size, title, _peak(where, most), parts)


def _curve(joint: Joint, place: int, landscape: Landscape) -> str:
    """Draw the density of one joint's angle, and a line for the uniform density."""
    across = _Axis(joint, _LEFT, _LEFT + _CURVE_WIDTH)
    angles = landscape.angles(place)
    values = landscape.along(place, angles)
    # The axis always contains 1, the uniform density, because it is the reference of all values.
    bottom, most = _TOP + _CURVE_HEIGHT, 1.08 * max(1.0, float(values.max()))
    heights = bottom - values / most * _CURVE_HEIGHT
    pairs = zip(across(angles), heights, strict=True)
    line = " ".join(f"{x:.1f} {y:.1f}" for x, y in pairs)
    parts = [
        *_axis_across(across, bottom),
        *_heights(most, bottom, across),
        f'<path class="area" d="M{_LEFT} {bottom}L{line}L{across.end} {bottom}z"/>',
        f'<path class="curve" d="M{line}"/>',
        f'<path class="before" d="M{_LEFT} {bottom - _CURVE_HEIGHT / most:.1f}H{across.end}"/>',
        *(
            f'<path class="rug" d="M{across(center):.1f} {bottom}v-7"/>'
            for center in landscape.centers[:, place]
        ),
    ]
    description = _peak(_shown(angles[values.argmax()], joint), float(values.max()))
    return _svg((across.end + 16, bottom + _BOTTOM), f"Density of {joint.name}", description, parts)


def _peak(where: str, most: float) -> str:
    return f"Likeliest at {where}: {most:.3g} times as likely as in a uniform density."


def _svg(size: tuple[float, float], title: str, description: str, parts: list[str]) -> str:
    width, height = size
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="density" width="{width:.0f}" '
        f'height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}" role="img">'
        f"<title>{escape(title)}</title><desc>{escape(description)}</desc>{''.join(parts)}</svg>"
    )


def _text(kind: str, x: float, y: float, text: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'


def _axis_across(axis: _Axis, y: float) -> Iterator[str]:
    for angle, x in axis.ticks(room=45):
        yield f'<path class="tick" d="M{x:.1f} {y:.1f}v5"/>'
        yield _text("middle", x, y + 14, angle)
    yield _text("middle", (axis.start + axis.end) / 2, y + 32, axis.label)


def _axis_up(axis: _Axis, x: float) -> Iterator[str]:
    for angle, y in axis.ticks(room=28):
        yield f'<path class="tick" d="M{x} {y:.1f}h-5"/>'
        yield _text("end", x - 8, y, angle)
    name = _text("middle", 0, 0, axis.label)
    middle = (axis.start + axis.end) / 2
    yield f'<g transform="translate(13 {middle:.1f}) rotate(-90)">{name}</g>'


def _scale(most: float, x: float, tall: float) -> Iterator[str]:
    """Yield the legend of a map's colours."""
    ramp = _image(np.linspace(1, 0, 64)[:, None])
    area = f'x="{x}" y="{_TOP}" width="12" height="{tall:.1f}"'
    yield f'<image {area} preserveAspectRatio="none" href="{ramp}"/>'
    for part in (0.0, 0.5, 1.0):
        yield _text("start", x + 17, _TOP + tall * (1 - part), f"{part * most:.2g} {_TIMES}")


def _heights(most: float, bottom: float, across: _Axis) -> Iterator[str]:
    """Yield the axis of a curve's heights: densities relative to the uniform one."""
    # The axis has at most five lines above zero, at 1, 2 or 5 times a power of ten.
    step = next((step for step in _HEIGHTS if most / step <= 5), most)
    for number in range(int(most / step) + 1):
        y = bottom - number * step / most * _CURVE_HEIGHT
        yield f'<path class="grid" d="M{across.start} {y:.1f}H{across.end}"/>'
        yield _text("end", across.start - 6, y, f"{number * step:g} {_TIMES}")


def _shown(position: float, joint: Joint) -> str:
    """Return a position of a joint with its shown unit."""
    factor, _, sign = SHOWN[joint.unit]
    return f"{factor * position:.0f}{sign}"


def _image(values: Floats) -> str:
    """Return values from 0 to 1 as colours (viridis), row by row from the top, as a data URL."""
    grey: NDArray[Any] = np.round(255 * values).astype(np.uint8)
    _, content = cv2.imencode(".png", cv2.applyColorMap(grey, cv2.COLORMAP_VIRIDIS))
    return "data:image/png;base64," + base64.b64encode(bytes(content)).decode()

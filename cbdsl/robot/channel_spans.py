"""Hues, saturations and values of each visual channel (Eq 3.10), as images have them: in bytes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

from cbdsl.documents.robot import Channels, ColorRange
from cbdsl.robot.channel_names import named_colors

#: Least and largest hue, saturation and value, each 0 to 255.
Span = tuple[tuple[int, ...], tuple[int, ...]]

_Interval = tuple[int, int]
_ALL: _Interval = (0, 255)


def channel_spans(channels: Channels) -> Mapping[str, tuple[Span, ...]]:
    """Return the spans of each channel but ``motion``; a pixel is in any span of its channel.

    Bins of hue are centred, ``hue_1`` on red, so that the noise of a pure colour stays in one bin.
    """
    lit = _inside(channels.least_intensity, 1.0)
    colored = _inside(channels.least_saturation, 1.0)
    spans = {
        name: tuple(span for each in ranges for span in _of_color(each))
        for name, ranges in named_colors(channels).items()
    }
    half = round(128 / channels.hue) if channels.hue else 0
    for name, (first, last) in _bins("hue", channels.hue):
        spans[name] = _boxes(_around(first - half, last - half), colored, lit)
    for name, bounds in _bins("sat", channels.saturation):
        spans[name] = _boxes([_ALL], bounds, lit)
    for name, bounds in _bins("int", channels.intensity):
        spans[name] = _boxes([_ALL], _ALL, bounds)
    return spans


def channels_of_color(color: Sequence[float], channels: Channels) -> tuple[str, ...]:
    """Return the names of the channels that contain a colour in white light.

    Args:
        color: Red, green and blue, each from 0 to 1.
        channels: Division of the images.
    """
    pixel = _hsv(color)
    return tuple(
        name
        for name, spans in channel_spans(channels).items()
        if any(
            all(low <= part <= high for low, part, high in zip(least, pixel, most, strict=True))
            for least, most in spans
        )
    )


def _of_color(color: ColorRange) -> tuple[Span, ...]:
    first, last = (turn % math.tau * 256 / math.tau for turn in color.hue)
    hues = _around(math.ceil(first), math.floor(last))
    return _boxes(hues, _inside(*color.saturation), _inside(*color.value))


def _inside(least: float, most: float) -> _Interval:
    return math.ceil(255 * least), math.floor(255 * most)


def _around(first: int, last: int) -> list[_Interval]:
    """Return the hues from a first to a last one as intervals, two if they pass 0."""
    first, last = first % 256, last % 256
    return [(first, last)] if first <= last else [(first, 255), (0, last)]


def _boxes(hues: Sequence[_Interval], saturation: _Interval, value: _Interval) -> tuple[Span, ...]:
    return tuple(
        ((low, saturation[0], value[0]), (high, saturation[1], value[1])) for low, high in hues
    )


def _bins(prefix: str, count: int) -> list[tuple[str, _Interval]]:
    """Return equal bins of all bytes by the names of their channels."""
    edges = [math.ceil(256 * index / count) for index in range(count + 1)] if count else []
    return [
        (f"{prefix}_{number}", (first, after - 1))
        for number, (first, after) in enumerate(pairwise(edges), 1)
    ]


def _hsv(color: Sequence[float]) -> tuple[int, int, int]:
    """Return hue, saturation and value of a colour as bytes, in OpenCV's integer arithmetic."""
    red, green, blue = (round(255 * part) for part in color)
    value = max(red, green, blue)
    chroma = value - min(red, green, blue)
    if not chroma:
        return 0, 0, value
    if value == red:
        turn = green - blue
    elif value == green:
        turn = blue - red + 2 * chroma
    else:
        turn = red - green + 4 * chroma
    saturation = (chroma * round((255 << 12) / value) + (1 << 11)) >> 12
    hue = (turn * round((256 << 12) / (6 * chroma)) + (1 << 11)) >> 12
    return hue % 256, saturation, value

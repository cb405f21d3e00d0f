"""Names of a robot's visual channels (Eq 3.10)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache

from cbdsl.documents.robot import Channels, ColorRange

ColorRanges = tuple[ColorRange, ...]


# First and last hue, deg, least saturation and least value of each range. People call a pale or a
# dark colour by its hue's name only if the other of saturation and value is high. A dull or dark
# orange is brown, and a dark yellow is olive or brown, so that dark ranges are narrower towards
# orange. Orange lies between red and yellow, cyan between green and blue.
_COLORS = {
    "red": ((345, 14, 0.65, 0.7), (345, 10, 0.8, 0.45)),
    "yellow": ((45, 70, 0.5, 0.75), (54, 70, 0.8, 0.6)),
    "green": ((80, 158, 0.35, 0.4), (80, 158, 0.5, 0.2)),
    "blue": ((190, 255, 0.4, 0.6), (190, 255, 0.5, 0.2)),
}


@cache
def _usual_colors() -> Mapping[str, ColorRanges]:
    """Return the colours that every robot has a name for."""
    return {
        name: tuple(
            ColorRange(
                hue=(math.radians(first), math.radians(last)),
                saturation=(saturation, 1.0),
                value=(value, 1.0),
            )
            for first, last, saturation, value in ranges
        )
        for name, ranges in _COLORS.items()
    }


def named_colors(channels: Channels) -> Mapping[str, ColorRanges]:
    """Return the ranges of each named colour; an alias takes the place of a colour of its name."""
    colors = {**_usual_colors(), **channels.colors}
    return {name: ranges for name, ranges in colors.items() if name not in channels.aliases}


def hue_names(channels: Channels) -> Iterator[str]:
    """Yield the names of the channels of hue: the named colours, then ``hue_1`` and on."""
    yield from named_colors(channels)
    yield from _bins("hue", channels.hue)


def bin_names(channels: Channels) -> Iterator[str]:
    """Yield the names that are not colours: ``hue_1`` and on, ``sat_1``, ``int_1``, ``motion``."""
    yield from _bins("hue", channels.hue)
    yield from _bins("sat", channels.saturation)
    yield from _bins("int", channels.intensity)
    if channels.motion:
        yield "motion"


def channel_names(channels: Channels) -> Iterator[str]:
    """Yield all names: the named colours, then those of ``bin_names``."""
    yield from named_colors(channels)
    yield from bin_names(channels)


def color_of(channel: str, channels: Channels) -> str:
    """Return the named colour of a bin of hue, by its middle; other channels as they are.

    Args:
        channel: Name of a channel or an alias.
        channels: Division of the images.
    """
    name = channels.aliases.get(channel, channel)
    kind, _, number = name.partition("_")
    if kind != "hue" or not number.isdigit():
        return name
    middle = (int(number) - 1) * math.tau / channels.hue
    colors = named_colors(channels).items()
    return next((color for color, ranges in colors if _has_hue(ranges, middle)), name)


def _has_hue(ranges: ColorRanges, hue: float) -> bool:
    """Return whether a hue, rad, is between the first and the last hue of a range."""
    return any(
        (hue - each.hue[0]) % math.tau <= (each.hue[1] - each.hue[0]) % math.tau for each in ranges
    )


def _bins(prefix: str, count: int) -> Iterator[str]:
    yield from (f"{prefix}_{number}" for number in range(1, count + 1))

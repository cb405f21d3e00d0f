"""Colours by the robot's channels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbdsl.documents.robot import Channels
from cbdsl.robot.channel_names import channel_names
from cbdsl.sensing.channels import ChannelFilter


class Palette:
    """Map from colours in white light to channels."""

    def __init__(self, channels: Channels) -> None:
        wanted = [name for name in channel_names(channels) if name != "motion"]
        self._filter = ChannelFilter(channels, wanted, least_area=1)
        self._known: dict[tuple[float, ...], tuple[str, ...]] = {}

    def channels(self, color: Sequence[float]) -> tuple[str, ...]:
        """Return the names of the channels of a colour: red, green and blue, each from 0 to 1."""
        key = tuple(color)
        if key not in self._known:
            pixel = np.rint(255 * np.array(color)).astype(np.uint8)
            self._known[key] = tuple(self._filter.regions(pixel.reshape(1, 1, 3)))
        return self._known[key]

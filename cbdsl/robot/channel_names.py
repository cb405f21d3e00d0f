"""The names of a robot's visual channels (Eq 3.10)."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.documents.robot import Channels


def channel_names(channels: Channels) -> Iterator[str]:
    """Names of all channels: ``hue_1`` and on, ``sat_1`` and on, ``int_1`` and on, ``motion``."""
    for prefix, count in (
        ("hue", channels.hue),
        ("sat", channels.saturation),
        ("int", channels.intensity),
    ):
        yield from (f"{prefix}_{number}" for number in range(1, count + 1))
    if channels.motion:
        yield "motion"

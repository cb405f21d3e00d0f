"""Names of a robot's visual channels (Eq 3.10)."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.documents.robot import Channels


def hue_names(channels: Channels) -> Iterator[str]:
    """Yield the names of the channels of hue: ``hue_1`` and on."""
    yield from (f"hue_{number}" for number in range(1, channels.hue + 1))


def channel_names(channels: Channels) -> Iterator[str]:
    """Yield all names: ``hue_1`` and on, ``sat_1`` and on, ``int_1`` and on, ``motion``."""
    yield from hue_names(channels)
    for prefix, count in (
        ("sat", channels.saturation),
        ("int", channels.intensity),
    ):
        yield from (f"{prefix}_{number}" for number in range(1, count + 1))
    if channels.motion:
        yield "motion"

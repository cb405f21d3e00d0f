"""Regions of ideal cameras as text, exactly."""

from __future__ import annotations

import json
from collections.abc import Mapping

from cbdsl.extend.backend import Extent, Moments, Region, Regions


def write_regions(regions: Mapping[str, Regions]) -> str:
    """Return the regions of an image, by channel, as JSON."""
    return json.dumps(regions, separators=(",", ":"))


def read_regions(text: str) -> dict[str, Regions]:
    """Return the regions that JSON holds.

    Raises:
        ValueError: The text is not an output of ``write_regions``.
    """
    try:
        return {
            channel: tuple(_region(*values) for values in several)
            for channel, several in json.loads(text).items()
        }
    except (AttributeError, TypeError) as error:
        raise ValueError(f"not regions: {error}") from None


def _region(
    area: int,
    column: float,
    row: float,
    clipped: bool,
    moments: list[float],
    extent: list[list[list[float]]] | None,
) -> Region:
    return Region(
        area, column, row, clipped, Moments(*moments), None if extent is None else _extent(extent)
    )


def _extent(extent: list[list[list[float]]]) -> Extent:
    outline, cover = extent
    return Extent(tuple((a, b, c, d) for a, b, c, d in outline), tuple((x, y) for x, y in cover))

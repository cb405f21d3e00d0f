"""Blobs of objects in a camera's image, one panel for each moment (Figures 7.15 and 7.16)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cbdsl_reproduction.figure import drawing

if TYPE_CHECKING:
    from matplotlib.patches import Ellipse

# Half-widths of the shown field of view, horizontally and vertically, rad.
_ACROSS, _UP = 0.365, 0.28
_LONGEST = 5

Blobs = Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class BlobPanels:
    """Picture of ellipses with the second moments of the regions.

    Attributes:
        name: Name of the file, without suffix.
        title: Title of the picture.
        panels: Blobs of each object by the description of the moment: heading and semi-axes, two
            angles each, and the direction of the longer axis if it has one, rad.
        colors: Colours of the objects.
    """

    name: str
    title: str
    panels: Mapping[str, Blobs]
    colors: Mapping[str, str]

    def data(self) -> dict[str, object]:
        """Return the blobs, for scripts."""
        return {
            moment: {thing: list(blob) for thing, blob in blobs.items()}
            for moment, blobs in self.panels.items()
        }

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        from matplotlib.patches import Patch

        count = len(self.panels)
        with drawing(2.4 * count, 2.6, self.title, columns=count) as draft:
            for axes, (moment, blobs) in zip(draft.panels, self.panels.items(), strict=True):
                axes.set_title(moment, parse_math=False, weight="normal")
                # Azimuth increases to the left.
                axes.set(xlim=(_ACROSS, -_ACROSS), ylim=(-_UP, _UP), xticks=(), yticks=())
                axes.set(aspect="equal", facecolor="#f4f4f4")
                for thing, blob in blobs.items():
                    axes.add_patch(_ellipse(blob, self.colors[thing])).set_gid(f"blob {thing}")
            keys = [
                Patch(color=color, label=thing.replace("_", " "))
                for thing, color in self.colors.items()
            ]
            draft.figure.legend(handles=keys, loc="outside lower left", ncols=len(keys))
        return draft.svg


def _ellipse(blob: tuple[float, ...], color: str) -> Ellipse:
    from matplotlib.patches import Ellipse

    azimuth, elevation, longer, shorter = blob[:4]
    # The mirrored axis of azimuths turns the angle to the direction of the image.
    turn = math.degrees(blob[4]) if len(blob) == _LONGEST else 0.0
    axes = 2 * longer, 2 * shorter
    return Ellipse((azimuth, elevation), *axes, angle=turn, facecolor=color, alpha=0.75)

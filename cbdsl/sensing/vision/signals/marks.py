"""Marks: headings to regions of another hue on an object (Section 4.3.2)."""

from __future__ import annotations

from collections import Counter

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.channels import Region
from cbdsl.sensing.vision.regions.camera import sight
from cbdsl.sensing.vision.signals.chosen_headings import ChosenHeadings
from cbdsl.types.resource import MarkHeading

# Largest share of the object's area; a larger region is the object itself or behind it.
_LARGEST = 0.5
# Semi-axis of a uniform ellipse in standard deviations.
_ELLIPSE = 2.0


class Marks(ChosenHeadings[MarkHeading]):
    """Headings to the largest mark on an object; the hue is kept while it is seen."""

    kind = MarkHeading

    def reset(self) -> None:
        """Forget the episode before."""
        super().reset()
        self._hues: dict[MarkHeading, str] = {}

    def _choose(self, source: MarkHeading) -> dict[str, Floats]:
        marks = {name: self._marks(name, source) for name in self._robot.main_cameras}
        areas: Counter[str] = Counter()
        for own in marks.values():
            areas.update({hue: region.area for hue, region in own.items()})
        if not areas:
            return {}
        before = self._hues.get(source, "")
        hue = self._hues[source] = before if before in areas else areas.most_common(1)[0][0]
        return {name: self._line(name, own[hue]) for name, own in marks.items() if hue in own}

    def _marks(self, camera: str, source: MarkHeading) -> dict[str, Region]:
        """Return the largest mark of each hue in a camera's image."""
        thing = self._vision.region(camera, source.channel)
        if thing is None:
            return {}
        seen = self._vision.seen.get(camera, {})
        marks = ((hue, each) for hue in source.hues for each in seen.get(hue, ()))
        own: dict[str, Region] = {}
        for hue, region in marks:
            if hue not in own and is_mark(region, thing):
                own[hue] = region
        return own

    def _line(self, name: str, region: Region) -> Floats:
        """Return the line of sight to a region, world frame, shape (3,)."""
        own = sight(self._robot.cameras[name], region.column, region.row)
        line: Floats = self._vision.field.frames[name].rotation.dot(own)
        return line


def is_mark(region: Region, thing: Region) -> bool:
    """Return whether a region is a small part of the area that an object's region covers.

    Args:
        region: Region of any hue.
        thing: Region of the object in the same image.
    """
    if region.clipped or region.area > _LARGEST * thing.area:
        return False
    # The Mahalanobis distance of the middles is at most 2 within the ellipse of the same moments.
    aside = np.array((region.column - thing.column, region.row - thing.row))
    own = thing.moments
    spread = np.array(((own.columns, own.mixed), (own.mixed, own.rows)))
    return bool(aside.dot(np.linalg.solve(spread, aside)) <= _ELLIPSE**2)

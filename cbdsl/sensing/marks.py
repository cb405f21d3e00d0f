"""Marks: headings to what has another hue on a thing than the thing itself (Section 4.3.2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.camera import sight
from cbdsl.sensing.channels import Region
from cbdsl.sensing.kept_sights import KeptSights
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.reading import Reading
from cbdsl.sensing.vision import Vision
from cbdsl.types.resource import MarkHeading, Resource

Floats = NDArray[np.float64]

# Of the thing's area: what is larger is the thing in its own hue, or something behind it.
_LARGEST = 0.5
# A uniform ellipse reaches so many deviations far.
_ELLIPSE = 2.0


class Marks:
    """Samples a hue among those of what is on a thing, and stays with it while it is seen.

    Args:
        robot: whose cameras look.
        kinematics: of the same robot.
        vision: what they see.
        resources: that are read.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        vision: Vision,
        resources: Iterable[Resource],
    ) -> None:
        self._robot, self._vision = robot, vision
        sources = dict.fromkeys(each.source for each in resources)
        self._sources = [each for each in sources if isinstance(each, MarkHeading)]
        self._sights = KeptSights(robot, kinematics)
        self.reset()

    def reset(self) -> None:
        """Forget the episode before."""
        self._sights.reset()
        self._hues: dict[MarkHeading, str] = {}

    def update(self, observation: Observation) -> None:
        """Look at the newest images; vision must be up to date."""
        if observation.images or observation.regions:
            for source in self._sources:
                self._look(source, observation.time)

    def heading(self, source: MarkHeading) -> Reading | None:
        """The mean heading over the cameras that see it, ``None`` while there is no mark."""
        return self._sights.heading(source)

    def _look(self, source: MarkHeading, time: float) -> None:
        """Take in the newest images: the hue of before, else that of the largest mark."""
        marks = {name: self._marks(name, source) for name in self._robot.cameras}
        areas: dict[str, int] = {}
        for own in marks.values():
            for hue, region in own.items():
                areas[hue] = areas.get(hue, 0) + region.area
        lines: dict[str, Floats] = {}
        if areas:
            before = self._hues.get(source)
            hue = before if before in areas else max(areas, key=areas.__getitem__)
            self._hues[source] = hue
            lines = {name: self._line(name, own[hue]) for name, own in marks.items() if hue in own}
        self._sights.renew(source, lines, self._vision.images, time)

    def _marks(self, camera: str, source: MarkHeading) -> Mapping[str, Region]:
        """The largest mark of each hue in a camera's image."""
        thing = self._vision.region(camera, source.channel)
        if thing is None:
            return {}
        marks = {}
        for hue in source.hues:
            regions = self._vision.seen.get(camera, {}).get(hue, ())
            own = next((each for each in regions if is_mark(each, thing)), None)
            if own is not None:
                marks[hue] = own
        return marks

    def _line(self, name: str, region: Region) -> Floats:
        """The line of sight to a region, world frame, shape (3,)."""
        frame = self._vision.field.frames[name]
        line: Floats = frame.rotation.dot(
            sight(self._robot.cameras[name], region.column, region.row)
        )
        return line


def is_mark(region: Region, thing: Region) -> bool:
    """Whether a region is a small part of what a thing's region covers.

    Args:
        region: of some hue.
        thing: the region of the thing, in the same image.
    """
    if region.clipped or region.area > _LARGEST * thing.area:
        return False
    aside = np.array((region.column - thing.column, region.row - thing.row))
    own = thing.moments
    spread = np.array(((own.columns, own.mixed), (own.mixed, own.rows)))
    return bool(aside.dot(np.linalg.solve(spread, aside)) <= _ELLIPSE**2)

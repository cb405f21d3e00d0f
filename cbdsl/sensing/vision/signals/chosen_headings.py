"""Chosen headings: to regions that are selected again in each image, regardless of objects."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Generic, NamedTuple, TypeVar

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.table.reading import CameraHeading, Reading, mean
from cbdsl.sensing.vision.regions.camera import heading, heading_jacobian
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import MarkHeading, NovelHeading, Resource
from cbdsl.types.source_record import sources_of

Chosen = TypeVar("Chosen", NovelHeading, MarkHeading)


class _Lines(NamedTuple):
    """Lines of sight by camera, the number of the images that show them, and their time, s."""

    lines: dict[str, Floats]
    image: int
    time: float


class ChosenHeadings(ABC, Generic[Chosen]):
    """Headings along lines of sight, which linger after their regions as other headings do.

    Their targets are assumed to stand still while the cameras move.

    Args:
        robot: Robot document with the cameras.
        kinematics: Kinematics of the same robot.
        vision: Regions in the images of the cameras.

    Attributes:
        kind: Source type of the resources that this class reads.
    """

    kind: type[Chosen]

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, vision: Vision) -> None:
        self._robot, self._kinematics, self._vision = robot, kinematics, vision
        self._sources: tuple[Chosen, ...] = ()
        self._linger = robot.vision.regions.linger
        self._places = {name: place for place, name in enumerate(robot.main_cameras)}
        self.reset()

    def follow(self, resources: Iterable[Resource]) -> None:
        """Follow the headings of more resources from now on."""
        more: tuple[Chosen, ...] = sources_of(resources, self.kind)
        self._sources += tuple([each for each in more if each not in self._sources])

    def reset(self) -> None:
        """Forget the episode before."""
        self._kept: dict[Chosen, _Lines] = {}

    def update(self, observation: Observation) -> None:
        """Update the lines of sight from new images; vision and kinematics must be up to date."""
        if not observation.images and not observation.regions:
            return
        for source in self._sources:
            lines = self._choose(source)
            if lines:
                self._kept[source] = _Lines(lines, self._vision.images, observation.time)
            elif self._is_due(source, observation.time):
                del self._kept[source]

    def heading(self, source: Chosen) -> Reading | None:
        """Return the mean heading over the cameras that see a target, ``None`` if none does."""
        kept = self._kept.get(source)
        if kept is None:
            return None
        return mean([self._reading(name, line, kept.image) for name, line in kept.lines.items()])

    @abstractmethod
    def _choose(self, source: Chosen) -> dict[str, Floats]:
        """Return lines of sight to the target in the newest images, world frame, by camera."""

    def _is_due(self, source: Chosen, time: float) -> bool:
        """Return whether the lines of sight of a source have lingered for their full time."""
        kept = self._kept.get(source)
        return kept is not None and time - kept.time > self._linger

    def _reading(self, camera: str, line: Floats, image: int) -> Reading:
        """Return the heading along a line of sight and its Jacobian by the camera's motion."""
        link = self._robot.cameras[camera].link
        angles = heading(self._kinematics.frame(link).rotation.T.dot(line))
        jacobian = heading_jacobian(angles).dot(self._kinematics.own_turning(link))
        cameras = (CameraHeading(self._places[camera], 1.0, angles),)
        return Reading(angles, jacobian, image, cameras=cameras)

"""Surfaces of the channels from which a program samples points."""

from __future__ import annotations

from collections.abc import Iterable

from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.vision.shapes.surface import LevelSurface, SurfaceView
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import Resource, SurfacePoint
from cbdsl.types.source_record import sources_of


class Surfaces:
    """Static surfaces by channel, which are remembered until the episode ends.

    Args:
        robot: Robot document with a stereo pair.
        vision: Regions in the images of the cameras.
        resources: Resources of the program.
    """

    def __init__(self, robot: RobotDocument, vision: Vision, resources: Iterable[Resource]) -> None:
        self._robot, self._vision = robot, vision
        self.by_channel: dict[str, LevelSurface] = {}
        self.follow(resources)

    def follow(self, resources: Iterable[Resource]) -> None:
        """Follow the surfaces of more resources from now on."""
        for source in sources_of(resources, SurfacePoint):
            self.by_channel.setdefault(source.channel, LevelSurface())

    def reset(self) -> None:
        """Forget the previous episode."""
        for surface in self.by_channel.values():
            surface.reset()

    def update(self, observation: Observation) -> None:
        """Update the surfaces from the newest images; vision must be up to date."""
        if not (observation.images or observation.regions):
            return
        for channel, surface in self.by_channel.items():
            views = [self._view(camera, channel) for camera in self._robot.main_cameras]
            left, right = views
            if left is not None and right is not None:
                surface.see(left, right)

    def _view(self, name: str, channel: str) -> SurfaceView | None:
        regions = self._vision.seen.get(name, {}).get(channel, ())
        extent = next((each.extent for each in regions if each.extent is not None), None)
        if extent is None:
            return None
        camera = self._robot.cameras[name]
        return SurfaceView(camera, self._vision.field.frames[name], extent)

"""Rendered cameras: images with the noise of their sensors."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.cameras.camera_system import CameraSystem, Chance, Exposure
from cbdsl.backends.cameras.renderer import Renderer
from cbdsl.backends.cameras.view import View
from cbdsl.backends.staging.engine import Engine
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.numeric.arrays import Image
from cbdsl.robot.channel_names import named_colors
from cbdsl.sensing.channels import ChannelFilter

# Rows and columns by which an image may be shifted on the sheet.
_ROOM = 64


class PixelNoise:
    """Normal noise of each pixel and colour, rounded to steps of the sensor.

    Drawing new noise for every image takes as long as rendering. So it is drawn once per episode on
    a sheet larger than an image, and every image takes a part of the sheet.

    Args:
        deviation: Standard deviation, of 255.
        rng: Generator of the noise.
    """

    def __init__(self, deviation: float, rng: np.random.Generator) -> None:
        self._deviation, self._rng = deviation, rng
        self._sheets: dict[tuple[int, int], NDArray[np.int16]] = {}

    def added(self, image: Image) -> Image:
        """Return a copy of an image with noise, shape (height, width, 3)."""
        if not self._deviation:
            return image.copy()
        height, width, _ = image.shape
        sheet = self._sheets.get((height, width))
        if sheet is None:
            sheet = self._sheets[height, width] = self._draw(height + _ROOM, width + _ROOM)
        # Two images of an episode share a shift in one of 4096 cases only. Otherwise their noise is
        # uncorrelated pixel by pixel.
        down, right = self._rng.integers(_ROOM, size=2).tolist()
        part = sheet[down : down + height, right : right + width]
        noisy: Image = cv2.add(image, part, dtype=cv2.CV_8U)  # saturates
        return noisy

    def _draw(self, height: int, width: int) -> NDArray[np.int16]:
        values = self._rng.standard_normal((height, width, 3), dtype=np.float32)
        noise: NDArray[np.int16] = np.rint(values * self._deviation).astype(np.int16)
        return noise


class RenderedCameras(CameraSystem):
    """Cameras whose images a renderer makes; see ``CameraSystem``.

    Args:
        robot: Robot document, which names the cameras and their links.
        renderer: Renderer of the images.
    """

    def __init__(self, robot: RobotDocument, renderer: Renderer) -> None:
        super().__init__(robot, renderer.name)
        self._renderer = renderer

    def begin(
        self,
        engine: Engine,
        disturbance: Disturbance,
        channels: Collection[str] | None,
        chance: Chance,
    ) -> None:
        """Begin an episode; images hold all channels."""
        super().begin(engine, disturbance, channels, chance)
        # Independent errors of sensor and stage add up in their variances.
        deviation = math.hypot(self._robot.vision.noise, disturbance.image_noise)
        self._noise = PixelNoise(deviation, chance.noise)

    def views(self) -> dict[str, View]:
        """Return the true views of all cameras, errors included."""
        views = {}
        for name, camera in self._cameras.items():
            pose, error = self._engine.link_pose(camera.link), self._errors.get(name)
            views[name] = View(camera, pose if error is None else pose @ error)
        return views

    def colors(self) -> tuple[str, ...]:
        """Return the named colours of the images, without noise."""
        vision = self._robot.vision
        names = tuple(named_colors(vision.channels))
        detector = ChannelFilter(vision.channels, names, vision.regions.least_area)
        images = self.render(self.views()).values()
        seen = {name for image in images for name in detector.regions(image)}
        return tuple(name for name in names if name in seen)

    def take(self) -> Exposure:
        """Return an image of every camera."""
        images = self.render(self.views())
        return Exposure({name: self._noise.added(image) for name, image in images.items()})

    def take_in_the_dark(self) -> Exposure:
        """Return a black image of every camera, with the noise of its sensor."""
        return Exposure(
            {
                name: self._noise.added(np.zeros((camera.height, camera.width, 3), np.uint8))
                for name, camera in self._cameras.items()
            }
        )

    def resolve(self, times: int) -> Mapping[str, Image]:
        """Return noiseless images of ``times`` as many pixels each way, for a custom sensor."""
        return self.render({name: view.resolved(times) for name, view in self.views().items()})

    def render(self, views: Mapping[str, View]) -> dict[str, Image]:
        """Return noiseless images from any views."""
        images = self._renderer.render(self._engine, list(views.values()))
        return dict(zip(views, images, strict=True))

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()

"""The robot's cameras: where they really are, when they take images, and the images' noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.bullet.body import Body
from cbdsl.backends.bullet.renderer import Renderer
from cbdsl.backends.bullet.view import View
from cbdsl.backends.staging.pose import Pose
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import Disturbance
from cbdsl.sensing.observation import Image

Floats = NDArray[np.float64]


def _direction(rng: np.random.Generator) -> Floats:
    """A unit vector, shape (3,), drawn evenly from all directions."""
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)


class Cameras:
    """The cameras in one episode.

    Each is where the robot's model has it but for an error, drawn once: a distance in a random
    direction and an angle about a random axis.

    Args:
        robot: names the cameras and their links.
        body: carries them.
        renderer: makes their images.
        disturbance: the sizes of their errors and of their noise.
        rng: draws the errors.
        noise: draws the noise.
    """

    def __init__(
        self,
        robot: RobotDocument,
        body: Body,
        renderer: Renderer,
        disturbance: Disturbance,
        rng: np.random.Generator,
        noise: np.random.Generator,
    ) -> None:
        self._cameras = robot.cameras
        self._links = {name: body.link(camera.link) for name, camera in robot.cameras.items()}
        self._body = body
        self._renderer = renderer
        self._deviation = disturbance.image_noise
        self._noise = noise
        self._errors = {name: self._error(disturbance, rng) for name in robot.cameras}

    @staticmethod
    def _error(disturbance: Disturbance, rng: np.random.Generator) -> Pose:
        turned = Pose.turned(_direction(rng), disturbance.camera_rotation)
        return Pose(disturbance.camera_position * _direction(rng), turned.rotation)

    def views(self) -> dict[str, View]:
        """Where the cameras really are."""
        poses = self._body.poses(list(self._links.values()))
        return {
            name: View(camera, pose @ self._errors[name])
            for (name, camera), pose in zip(self._cameras.items(), poses, strict=True)
        }

    def take(self) -> Mapping[str, Image]:
        """An image by every camera."""
        images = self._renderer.render(list(self.views().values()))
        return {
            name: self._disturbed(image) for name, image in zip(self._cameras, images, strict=True)
        }

    def resolve(self, times: int) -> Mapping[str, Image]:
        """What falls on every sensor, with ``times`` as many pixels each way and without noise.

        For whoever wants to let a lens and a sensor of his own make an image of it.
        """
        views = [view.resolved(times) for view in self.views().values()]
        return dict(zip(self._cameras, self._renderer.render(views), strict=True))

    def _disturbed(self, image: Image) -> Image:
        if not self._deviation:
            return image
        values = self._noise.standard_normal(image.shape, dtype=np.float32)
        values *= self._deviation
        values += image
        return np.clip(np.rint(values, out=values), 0, 255, out=values).astype(np.uint8)

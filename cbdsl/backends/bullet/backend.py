"""The reference backend: PyBullet's physics, rendered stereo images and fingertip load cells."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet as p

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.engine import BulletEngine
from cbdsl.backends.cameras import light
from cbdsl.backends.cameras.selection import make_cameras
from cbdsl.backends.cameras.view import View
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.fit import physics_steps, read_fitting, require_meshes
from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.arrays import Image


class BulletBackend(SimulatedBackend[BulletEngine]):
    """A robot in PyBullet, with contacts and forces.

    Args:
        robot: Robot document.
        urdf: URDF of the robot.
        gui: True to open the simulator's window.
        cameras: ``rendered`` or ``ideal``; rendered if ``None``.

    Raises:
        BackendError: Robot file and model do not fit together, the requested renderer does not work
            here, or there is no screen for a window.
    """

    def __init__(
        self, robot: RobotDocument, urdf: Path, *, gui: bool = False, cameras: str | None = None
    ) -> None:
        if gui and sys.platform == "linux" and not os.environ.get("DISPLAY"):
            # The simulator would end the process.
            raise BackendError("the simulator's window needs a screen, but DISPLAY is not set")
        model, substeps = read_fitting(robot, urdf), physics_steps(robot)
        require_meshes(model, model.meshes)
        engine = BulletEngine(robot, model, 1 / robot.control.rate / substeps, gui=gui)
        try:
            own = {"tiny": lambda: TinyRenderer(engine.client)}
            eyes = make_cameras(cameras, robot, model, own)
        except BackendError:
            engine.close()
            raise
        super().__init__(robot, model, engine, eyes, robot.control.rate, substeps)


# Grey of 0.78, as in the OpenGL renderer.
_BACKGROUND = 199


class TinyRenderer:
    """Renderer by PyBullet's TinyRenderer, without shadows.

    Its spheres are coarse polyhedra, which shifts the centroids of regions a little.
    """

    name = "tiny (PyBullet's software renderer)"

    def __init__(self, client: int) -> None:
        self._client = client

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """Return images of all bodies from each view; see ``Renderer.render``."""
        return [self._image(view) for view in views]

    def _image(self, view: View) -> Image:
        width, height = view.camera.width, view.camera.height
        projection = view.eye_to_clip()
        # TinyRenderer samples pixels at their lower left corners: half a pixel centres the samples.
        projection[0, 2], projection[1, 2] = 1 / width, 1 / height
        _, _, colors, _, bodies = p.getCameraImage(
            width,
            height,
            viewMatrix=view.world_to_eye().T.ravel().tolist(),
            projectionMatrix=projection.T.ravel().tolist(),
            shadow=0,
            lightDirection=list(light.DIRECTION),
            lightAmbientCoeff=light.AMBIENT,
            lightDiffuseCoeff=1 - light.AMBIENT,
            lightSpecularCoeff=0.0,
            renderer=p.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        image = np.array(colors, dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
        image[np.reshape(bodies, (height, width)) < 0] = _BACKGROUND
        return np.ascontiguousarray(image)

    def close(self) -> None:
        """Do nothing: there are no resources to free."""

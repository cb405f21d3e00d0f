"""Images by the simulator's own software renderer: slower, but it runs everywhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet as p

from cbdsl.backends.cameras import light
from cbdsl.backends.cameras.view import View
from cbdsl.backends.staging.engine import Engine
from cbdsl.numeric.arrays import Image

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

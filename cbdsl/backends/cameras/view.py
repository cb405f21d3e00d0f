"""Pinhole camera at a pose: the one camera model of all renderers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.documents.robot import Camera
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats

NEAREST, FARTHEST = 0.05, 10.0


@dataclass(frozen=True)
class View:
    """View of a camera with this frame: along +x, with +y to the left and +z up.

    A point (x, y, z) of the camera's frame appears at (w/2 - f y/x, h/2 - f z/x), px. The origin is
    the outer corner of the top left pixel, so that pixel centres are at halves.
    """

    camera: Camera
    pose: Pose

    def resolved(self, times: int) -> View:
        """Return the same view, with ``times`` as many pixels each way."""
        camera = self.camera
        finer = {
            "width": times * camera.width,
            "height": times * camera.height,
            "focal_length": times * camera.focal_length,
        }
        return View(camera.model_copy(update=finer), self.pose)

    def world_to_eye(self) -> Floats:
        """Return the transform, shape (4, 4), to OpenGL's eye frame: x right, y up, z back."""
        axes = self.pose.rotation.T
        transform = np.eye(4)
        transform[:3, :3] = [-axes[1], axes[2], -axes[0]]
        transform[:3, 3] = -transform[:3, :3] @ self.pose.position
        return transform

    def eye_to_clip(self) -> Floats:
        """Return the perspective projection, shape (4, 4), from OpenGL's eye to clip space."""
        camera, depth = self.camera, FARTHEST - NEAREST
        projection = np.zeros((4, 4))
        # The image has the width 2 in clip space. Depth is mapped from near and far to -1 and 1,
        # after the division by the distance ahead.
        projection[0, 0] = 2 * camera.focal_length / camera.width
        projection[1, 1] = 2 * camera.focal_length / camera.height
        projection[2, 2:] = -(FARTHEST + NEAREST) / depth, -2 * FARTHEST * NEAREST / depth
        projection[3, 2] = -1
        return projection

"""Images of cameras as inputs of networks: the newest ones, resized to the model's pixels."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import BackendError, Image, Observation
from cbdsl.extend.source import Signals
from cbdsl_onnx.plan import InputPlan

#: Images in a row that may be missing before an input is undefined.
_MISSING = 3


class CameraImages:
    """Newest images of the cameras that a network sees.

    Args:
        network: Name of the network, for messages.
        cameras: Cameras.
        signals: Signals of the robot, which pass each observation on.
    """

    def __init__(self, network: str, cameras: Iterable[str], signals: Signals) -> None:
        self._network, self._cameras = network, tuple(cameras)
        self._signals = signals
        vision = signals.robot.vision
        self._longest = _MISSING / vision.rate + vision.latency
        self._newest: dict[str, tuple[float, Image]] = {}
        if self._cameras:
            signals.observers.append(self._note)

    def _note(self, observation: Observation) -> None:
        """Keep the images of an observation.

        Raises:
            BackendError: The cameras report regions in place of images.
        """
        if observation.regions and not observation.images:
            cameras = ", ".join(self._cameras)
            raise BackendError(
                f"network '{self._network}' needs images of {cameras}, but ideal cameras make "
                "none; run it with --cameras rendered"
            )
        for camera, image in observation.images.items():
            self._newest[camera] = observation.time, image

    def read(self, camera: str) -> Image | None:
        """Return the newest image of a camera, RGB; ``None`` if three in a row are missing."""
        time, image = self._newest.get(camera, (0.0, None))
        # The time of an earlier episode may be later than the present.
        return image if 0.0 <= self._signals.time - time <= self._longest else None


def pixels(image: Image, plan: InputPlan) -> NDArray[Any]:
    """Return an image with the size, the order and the type of an input.

    Bytes stay as they are. Floats are from 0 to 1 before their normalisation.

    Args:
        image: RGB image, shape (height, width, 3).
        plan: Input of the model.
    """
    height, width = plan.size
    is_smaller = height <= image.shape[0] and width <= image.shape[1]
    way = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
    resized: NDArray[Any] = cv2.resize(image, (width, height), interpolation=way)
    if plan.dtype != "uint8":
        scaled = resized / np.float32(255.0)
        mean, deviation = plan.scale
        scaled = scaled - np.array(mean or 0.0, np.float32)
        resized = (scaled / np.array(deviation or 1.0, np.float32)).astype(plan.dtype)
    return resized.transpose(2, 0, 1) if plan.channels_first else resized

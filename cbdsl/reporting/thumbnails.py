"""Camera images, small enough for a page."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

#: Maximum number of images of one camera on a page.
_MOST = 360
_QUALITY = 60


def chosen(count: int) -> NDArray[np.intp]:
    """Return indices of the images to keep of ``count``, evenly spaced, including the last."""
    if count <= _MOST:
        return np.arange(count)
    return np.linspace(0, count - 1, _MOST).round().astype(np.intp)


def encoded(images: NDArray[np.uint8]) -> list[bytes]:
    """Return images, RGB, shape (images, height, width, 3), each as a WebP file."""
    return [_webp(image) for image in images]


def _webp(image: NDArray[Any]) -> bytes:
    # OpenCV encodes images in the order blue, green, red.
    blue_first = np.ascontiguousarray(image[..., ::-1])
    _, content = cv2.imencode(".webp", blue_first, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
    return bytes(content)

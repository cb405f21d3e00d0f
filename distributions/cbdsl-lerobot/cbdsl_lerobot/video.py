"""MP4 videos of the images of one episode, H.264 with a key frame at every second image.

Training reads single frames at random. Key frames this near make that cheap.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.export import UsageError

_CODEC, _FORMAT = "libx264", "yuv420p"
# Quality at which errors are smaller than the noise of the images, and the distance of key frames.
_OPTIONS = {"crf": "18", "g": "2"}


def write_video(path: Path, images: NDArray[np.uint8], rate: int) -> None:
    """Write RGB images, shape (images, height, width, 3), at a rate in Hz.

    Raises:
        UsageError: The height or the width is odd, which this format does not have.
        OSError: The file cannot be written.
    """
    _, height, width, _ = images.shape
    if height % 2 or width % 2:
        raise UsageError(
            f"videos need an even height and width, and images are {width} x {height}; "
            "leave --videos out"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(_CODEC, rate=Fraction(rate), options=_OPTIONS)
        assert isinstance(stream, av.VideoStream), "the codec is one of videos"
        stream.width, stream.height, stream.pix_fmt = width, height, _FORMAT
        for image in images:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="rgb24")
            container.mux(stream.encode(frame))
        # The encoder delays images; a call without one returns the rest.
        container.mux(stream.encode())


def video_info(height: int, width: int, rate: int) -> dict[str, Any]:
    """Return the description of a video as the dataset's ``info.json`` has it."""
    return {
        "video.height": height,
        "video.width": width,
        "video.codec": "h264",
        "video.pix_fmt": _FORMAT,
        "video.is_depth_map": False,
        "video.fps": rate,
        "video.channels": 3,
        "has_audio": False,
    }

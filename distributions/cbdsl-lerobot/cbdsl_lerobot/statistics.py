"""Statistics of features, by which policies scale their inputs.

Images are counted in histograms of their 256 values, so that statistics are exact without keeping
any image.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.export import Floats
from cbdsl_lerobot.dataset_frames import Frames

Row = dict[str, Any]

_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
_VALUES = np.arange(256) / 255.0


class Statistics:
    """Statistics of the frames of any number of episodes."""

    def __init__(self) -> None:
        self._numbers: dict[str, list[Floats]] = {}
        self._histograms: dict[str, NDArray[np.int64]] = {}
        self._frames = 0

    def add(self, frames: Frames, columns: Mapping[str, NDArray[Any]]) -> None:
        """Add an episode.

        Args:
            frames: Frames of the episode.
            columns: Further numbers, by feature, one per frame.
        """
        for name, values in {**frames.numbers, **columns}.items():
            rows = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
            self._numbers.setdefault(name, []).append(rows)
        for name, images in frames.images.items():
            self._histograms[name] = self._histograms.get(name, 0) + _histogram(images)
        self._frames += len(frames)

    def table(self) -> dict[str, Row]:
        """Return the statistics by feature, as JSON has them."""
        rows = {name: _of_numbers(np.concatenate(v)) for name, v in self._numbers.items()}
        rows |= {name: _of_histogram(counts) for name, counts in self._histograms.items()}
        return {name: {**row, "count": [self._frames]} for name, row in rows.items()}


def _histogram(images: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return how often each channel has each value, shape (3, 256)."""
    channels = np.moveaxis(images, -1, 0).reshape(3, -1)
    return np.stack([np.bincount(channel, minlength=256) for channel in channels])


def _of_numbers(values: Floats) -> Row:
    """Return statistics of the defined values: signals are NaN while they are undefined."""
    row: Row = {
        "min": np.nanmin(values, axis=0).tolist(),
        "max": np.nanmax(values, axis=0).tolist(),
        "mean": np.nanmean(values, axis=0).tolist(),
        "std": np.nanstd(values, axis=0).tolist(),
    }
    for name, share in _QUANTILES.items():
        row[name] = np.nanquantile(values, share, axis=0).tolist()
    return row


# Model: the q-quantile is the least value at which the cumulative share reaches q. Its resolution
# is 1/255, the resolution of the images. `argmax` of a Boolean array is the index of its first
# True.
def _of_histogram(counts: NDArray[np.int64]) -> Row:
    """Return statistics per channel, each of shape (3, 1, 1), of values from 0 to 1."""
    shares = counts / counts.sum(axis=1, keepdims=True)
    reached = np.cumsum(shares, axis=1)
    mean = shares @ _VALUES
    variance = (shares * (_VALUES - mean[:, None]) ** 2).sum(axis=1)
    row = {
        "min": _VALUES[np.argmax(counts > 0, axis=1)],
        "max": _VALUES[255 - np.argmax(counts[:, ::-1] > 0, axis=1)],
        "mean": mean,
        "std": np.sqrt(variance),
    }
    for name, share in _QUANTILES.items():
        row[name] = _VALUES[np.argmax(reached >= share, axis=1)]
    return {name: values.reshape(3, 1, 1).tolist() for name, values in row.items()}

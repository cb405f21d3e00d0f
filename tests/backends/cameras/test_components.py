"""The largest connected component, as OpenCV labels them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numba import njit

from cbdsl.backends.cameras.silhouettes import keep_largest


@njit
def _kept(seen: np.ndarray, size: int) -> None:
    keep_largest(seen, size)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.9])
def test_kept_mask_is_the_largest_component(share: float) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        seen = rng.random((20, 20)) < share
        _, labels, stats, _ = cv2.connectedComponentsWithStats(seen.astype(np.uint8), 8)
        areas = stats[1:, cv2.CC_STAT_AREA]
        kept = seen.copy()
        _kept(kept, 20)
        assert kept.sum() == areas.max()
        assert len(set(labels[kept])) == 1


def test_cells_beyond_the_size_are_left_alone() -> None:
    seen = np.ones((5, 5), dtype=bool)
    seen[:3, 1] = False
    _kept(seen, 3)
    assert seen[:3, :3].sum() == 3
    assert seen[3:].all() and seen[:, 3:].all()


def test_empty_mask_stays_empty() -> None:
    seen = np.zeros((4, 4), dtype=bool)
    _kept(seen, 4)
    assert not seen.any()

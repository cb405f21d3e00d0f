"""Missing motion in views of a hand that do not determine the cameras' displacements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cbdsl_calibration.hand_view import HandView

# Measures of good views: ratio of the farthest to the nearest distance, standard deviation of
# image points, px, and standard deviation of the hand's directions before the camera.
_RANGE, _SPREAD, _TURN = 1.25, 20.0, 0.15


def lacking(views: Mapping[str, Sequence[HandView]], least: float = 1.0) -> str | None:
    """Return a sentence on the motion that views by several cameras lack most.

    Args:
        views: Views by camera.
        least: Sufficient share of a good calibration's motion.

    Returns:
        Sentence; ``None`` if all views have that share.
    """
    needs = [need for name, own in views.items() for need in _needs(name, own)]
    share, sentence = min(needs)
    return sentence if share < least else None


def _needs(camera: str, views: Sequence[HandView]) -> Iterator[tuple[float, str]]:
    """Yield the motion as shares of good views, each with the remedy if it is small."""
    distances = [float(np.linalg.norm(view.tips[0] - view.position)) for view in views]
    near, far = min(distances), max(distances)
    yield (
        (far / near - 1) / (_RANGE - 1),
        f"the hand stayed {100 * near:.0f} to {100 * far:.0f} cm from camera {camera}; "
        "move it nearer and farther",
    )
    points = np.array([view.point for view in views])
    yield (
        float(points.std(axis=0).min()) / _SPREAD,
        f"camera {camera} saw it in one part of the image only; show it near the corners, too",
    )
    yield (
        _turning(views) / _TURN,
        f"the hand kept its direction before camera {camera}; turn it about its wrist",
    )


def _turning(views: Sequence[HandView]) -> float:
    """Return the largest deviation of fingertip directions in the camera's frame."""
    sides = np.array([view.rotation.T @ (view.tips[1] - view.tips[0]) for view in views])
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    return float(sides.std(axis=0).max())

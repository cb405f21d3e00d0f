"""Views of solids from a camera, and selection of the solids that may occlude another one."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.backends.staging.solids import BALL, CYLINDER, into
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled

Window = tuple[float, float, float, float]

#: Number of values that describe a view.
VIEW = 22

_NEAREST = 0.02
"""Least distance from a camera at which an object is visible, m."""

_ROUNDING = 1e-6
"""Upper bound of the rounding error of any distance, m."""

_TOUCHING = 1e-9
"""Largest depth at which one solid only touches another, m."""


@compiled
def _span(ahead: float, aside: float, radius: float) -> tuple[float, float]:
    """Return the slopes between which a ball is seen, in the plane of the axes ahead and aside."""
    # Along the third axis, the ball's projection onto this plane is a disc of the same radius. The
    # slopes are those of the two tangents from the camera to the disc.
    distance = math.hypot(ahead, aside)
    if distance <= radius:
        return -math.inf, math.inf
    middle, half = math.atan2(aside, ahead), math.asin(radius / distance)
    low, high = middle - half, middle + half
    limit = 0.5 * math.pi - 1e-3
    return (
        math.tan(low) if low > -limit else -math.inf,
        math.tan(high) if high < limit else math.inf,
    )


@compiled
def _circumscribed(solid: Floats) -> float:
    """Return the radius of a ball around a solid's centre that contains the solid."""
    return math.sqrt(solid[1] ** 2 + solid[2] ** 2 + solid[3] ** 2)


@compiled
def _frame(solid: Floats, centre: Floats, view: Floats) -> tuple[float, float, float, float]:
    """Return slopes within which a solid is seen: left, right, bottom, top, as y / x and z / x.

    Args:
        solid: Row of the solid, shape (16,).
        centre: Centre of the solid in the camera's frame, m, shape (3,).
        view: View with the solid's axes in the camera's frame; see ``view_of``.
    """
    radius = solid[1]
    if solid[0] != BALL:
        radius = _circumscribed(solid)
    if centre[0] + radius <= _NEAREST:
        # Behind the camera: an empty window, whose left end exceeds its right end.
        return 1.0, -1.0, 1.0, -1.0
    # Corners beside or behind the camera have no valid slopes. The ball around such a solid bounds
    # it.
    if solid[0] == BALL or centre[0] - radius <= _NEAREST:
        left, right = _span(centre[0], centre[1], radius)
        bottom, top = _span(centre[0], centre[2], radius)
        return left, right, bottom, top
    left, right, bottom, top = math.inf, -math.inf, math.inf, -math.inf
    for corner in range(8):
        a = solid[1] if corner & 1 else -solid[1]
        b = solid[2] if corner & 2 else -solid[2]
        c = solid[3] if corner & 4 else -solid[3]
        x = centre[0] + view[7] * a + view[8] * b + view[9] * c
        y = (centre[1] + view[10] * a + view[11] * b + view[12] * c) / x
        z = (centre[2] + view[13] * a + view[14] * b + view[15] * c) / x
        left, right = min(left, y), max(right, y)
        bottom, top = min(bottom, z), max(top, z)
    return left, right, bottom, top


@compiled
def view_of(solid: Floats, camera: Floats, view: Floats) -> None:
    """Compute the view of a solid from a camera.

    Args:
        solid: Row of the solid, shape (16,).
        camera: Placement, as in ``Engine``, with axes ahead, left and up, shape (12,).
        view: Output, shape (22,): shape and halves; the camera's position in the solid's frame; the
            solid's axes in the camera's frame; the slopes within which it is seen; and the
            distances ahead at which it begins and ends, m.
    """
    centre = np.empty(3)
    x, y, z = solid[4] - camera[9], solid[5] - camera[10], solid[6] - camera[11]
    for i in range(3):
        centre[i] = camera[i] * x + camera[3 + i] * y + camera[6 + i] * z
        for j in range(3):
            view[7 + 3 * i + j] = (
                camera[i] * solid[7 + j]
                + camera[3 + i] * solid[10 + j]
                + camera[6 + i] * solid[13 + j]
            )
    for i in range(4):
        view[i] = solid[i]
    view[4], view[5], view[6] = into(solid, -x, -y, -z)
    view[16], view[17], view[18], view[19] = _frame(solid, centre, view)
    radius = _circumscribed(solid)
    view[20], view[21] = centre[0] - radius, centre[0] + radius


@compiled
def _beside(solid: Floats, camera: Floats, window: Window, end: float) -> bool:
    """Return whether the ball around a solid is outside a window, or farther ahead than its end.

    This test is much faster than the solid's view.
    """
    left, right, bottom, top = window
    radius = _circumscribed(solid) + _ROUNDING
    x, y, z = solid[4] - camera[9], solid[5] - camera[10], solid[6] - camera[11]
    ahead = camera[0] * x + camera[3] * y + camera[6] * z
    aside = camera[1] * x + camera[4] * y + camera[7] * z
    up = camera[2] * x + camera[5] * y + camera[8] * z
    # The side of the window at the slope s is the plane aside = s * ahead. Its normal has the
    # length sqrt(1 + s^2). The ball is outside if its centre is farther than its radius beyond that
    # plane.
    beside: bool = (
        ahead + radius < 0.0
        or ahead - radius > end
        or aside - right * ahead > radius * math.sqrt(1.0 + right * right)
        or left * ahead - aside > radius * math.sqrt(1.0 + left * left)
        or up - top * ahead > radius * math.sqrt(1.0 + top * top)
        or bottom * ahead - up > radius * math.sqrt(1.0 + bottom * bottom)
    )
    return beside


@compiled
def _reach(solid: Floats, x: float, y: float, z: float) -> float:
    """Return a solid's extent from its centre along a unit vector of the world frame, m."""
    a, b, c = float(solid[1]), float(solid[2]), float(solid[3])
    if solid[0] == BALL:
        return a
    u, v, w = into(solid, x, y, z)
    if solid[0] == CYLINDER:
        return a * math.sqrt(u * u + v * v) + c * abs(w)
    return a * abs(u) + b * abs(v) + c * abs(w)


@compiled
def _parted(solid: Floats, view: Floats, target: Floats) -> bool:
    """Return whether a plane separates a solid from target and camera, so that it cannot occlude.

    A plane separates an object from its support, and a hand from an object that it reaches for from
    behind. Only the sides of the box around the solid are tested.

    Args:
        solid: Row of the solid, shape (16,).
        view: The camera's view of this solid, shape (22,).
        target: Row of the target, shape (16,).
    """
    # If camera and target are beyond the same side of the box around the solid, all lines of sight
    # between them are, too.
    x, y, z = target[4] - solid[4], target[5] - solid[5], target[6] - solid[6]
    for i in range(3):
        u, v, w = solid[7 + i], solid[10 + i], solid[13 + i]
        side = math.copysign(1.0, view[4 + i])
        if side * view[4 + i] > solid[1 + i]:
            nearest = side * (u * x + v * y + w * z) - _reach(target, u, v, w)
            if nearest > solid[1 + i] - _TOUCHING:
                return True
    return False


@compiled
def views_before(solids: Floats, camera: Floats, target: int, window: Window, views: Floats) -> int:
    """Append the views of all solids that may occlude a target in a window of slopes.

    Args:
        solids: Rows of the solids, shape (k, 16).
        camera: Placement of the camera, shape (12,).
        target: Index of the target among the solids.
        window: Slopes of the window.
        views: Output, shape (k, 22): the first row is the target's view, and the others' follow.

    Returns:
        Number of views.
    """
    left, right, bottom, top = window
    end, count = views[0, 21], 1
    for index in range(len(solids)):
        if index == target or _beside(solids[index], camera, window, end):
            continue
        # A row that turns out to be irrelevant is overwritten by the next solid.
        view = views[count]
        view_of(solids[index], camera, view)
        aside = view[16] > right or view[17] < left or view[18] > top or view[19] < bottom
        if aside or view[20] >= end or _parted(solids[index], view, solids[target]):
            continue
        count += 1
    return count

"""Silhouettes: the visible part of solids, and what solids hide of each other."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.solids import BALL, CYLINDER, WIDTH, attach, into
from cbdsl.numeric.compiled import compiled, compiled_once

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
Booleans = NDArray[np.bool_]
Triple = tuple[float, float, float]
Window = tuple[float, float, float, float]
Patch = tuple[float, float, float, float]

#: All of a surface, as a patch.
WHOLE = (0.0, 1.0, -math.inf, math.inf)

#: Numbers that describe a silhouette.
SHAPE = 7

_NEAREST = 0.02
"""Least distance from a camera at which anything is seen, m."""

_ROUNDING = 1e-6
"""More than rounding makes of any distance, m."""

_TOUCHING = 1e-9
"""Largest depth at which one solid only touches another, m."""


@compiled
def _slab(origin: float, direction: float, half: float) -> tuple[float, float]:
    """Interval of a ray between two planes."""
    if direction == 0.0:
        return (-math.inf, math.inf) if abs(origin) <= half else (math.inf, -math.inf)
    near, far = (-half - origin) / direction, (half - origin) / direction
    return (near, far) if near <= far else (far, near)


@compiled
def _round(a: float, b: float, c: float) -> tuple[float, float]:
    """Interval in which a t^2 + 2 b t + c is not positive."""
    root = b * b - a * c
    if root < 0.0 or a == 0.0:
        return (-math.inf, math.inf) if a == 0.0 and c <= 0.0 else (math.inf, -math.inf)
    root = math.sqrt(root)
    return (-b - root) / a, (-b + root) / a


@compiled
def _entered(kind: float, halves: Triple, origin: Triple, direction: Triple) -> float:
    """Distance along a ray, in a solid's frame, to its entry; infinite if there is none."""
    x, y, z = origin
    u, v, w = direction
    if kind == BALL:
        square = x * x + y * y + z * z - halves[0] * halves[0]
        near, far = _round(u * u + v * v + w * w, u * x + v * y + w * z, square)
    else:
        near, far = _slab(z, w, halves[2])
        if near > far or far <= 0.0:
            return math.inf
        if kind == CYLINDER:
            square = x * x + y * y - halves[0] * halves[0]
            enter, leave = _round(u * u + v * v, u * x + v * y, square)
            near, far = max(near, enter), min(far, leave)
        else:
            enter, leave = _slab(x, u, halves[0])
            near, far = max(near, enter), min(far, leave)
            if near > far or far <= 0.0:
                return math.inf
            enter, leave = _slab(y, v, halves[1])
            near, far = max(near, enter), min(far, leave)
    return near if 0.0 < near <= far else math.inf


@compiled
def _span(ahead: float, aside: float, radius: float) -> tuple[float, float]:
    """Slopes between which a ball is seen, in the plane of the axis ahead and one aside."""
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
    """The radius of a ball around its centre that contains a solid."""
    return math.sqrt(solid[1] ** 2 + solid[2] ** 2 + solid[3] ** 2)


@compiled
def _frame(solid: Floats, centre: Floats, view: Floats) -> tuple[float, float, float, float]:
    """Slopes within which a solid is seen: (left, right, bottom, top) as y / x and z / x.

    Args:
        solid: shape (16,).
        centre: the solid's in the camera's frame, m, shape (3,).
        view: has the solid's axes in the camera's frame, see ``_view``.
    """
    radius = solid[1]
    if solid[0] != BALL:
        radius = _circumscribed(solid)
    if centre[0] + radius <= _NEAREST:
        return 1.0, -1.0, 1.0, -1.0
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
def _view(solid: Floats, camera: Floats, view: Floats) -> None:
    """A solid as a camera has it.

    Args:
        solid: shape (16,).
        camera: its placement, as ``Engine`` has it, with the axes ahead, left and up, shape (12,).
        view: takes shape and halves; the camera's position in the solid's frame; the solid's axes
            in the camera's frame; the slopes within which it is seen; and how far ahead it begins
            and ends, m; shape (22,).
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
    """Whether the ball around a solid is out of a camera's window, or farther ahead than its end.

    That is shapes much faster than the solid's own view.
    """
    left, right, bottom, top = window
    radius = _circumscribed(solid) + _ROUNDING
    x, y, z = solid[4] - camera[9], solid[5] - camera[10], solid[6] - camera[11]
    ahead = camera[0] * x + camera[3] * y + camera[6] * z
    aside = camera[1] * x + camera[4] * y + camera[7] * z
    up = camera[2] * x + camera[5] * y + camera[8] * z
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
    """Extent of a solid from its centre along a unit vector of the world frame, m."""
    a, b, c = float(solid[1]), float(solid[2]), float(solid[3])
    if solid[0] == BALL:
        return a
    u, v, w = into(solid, x, y, z)
    if solid[0] == CYLINDER:
        return a * math.sqrt(u * u + v * v) + c * abs(w)
    return a * abs(u) + b * abs(v) + c * abs(w)


@compiled
def _parted(solid: Floats, view: Floats, target: Floats) -> bool:
    """Whether a plane parts a solid from a target and from the camera, and so does not hide it.

    What stands on something is parted from it, and so is a hand that reaches for something from
    behind. Only the sides of the box around the solid are tried.

    Args:
        solid: shape (16,).
        view: the camera's of this solid, shape (22,).
        target: shape (16,).
    """
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
def _relevant(solids: Floats, camera: Floats, target: int, window: Window, views: Floats) -> int:
    """Add to the view of a solid those of all that may be before it in a window of slopes.

    Args:
        solids: shape (k, 16).
        camera: its placement, shape (12,).
        target: which of the solids it is.
        window: slopes.
        views: its first row is the target's view, the next ones take the others', shape (k, 22).

    Returns:
        How many views there are.
    """
    left, right, bottom, top = window
    end, count = views[0, 21], 1
    for index in range(len(solids)):
        if index == target or _beside(solids[index], camera, window, end):
            continue
        view = views[count]
        _view(solids[index], camera, view)
        aside = view[16] > right or view[17] < left or view[18] > top or view[19] < bottom
        if aside or view[20] >= end or _parted(solids[index], view, solids[target]):
            continue
        count += 1
    return count


@compiled
def _within(patch: Patch, origin: Triple, ray: Triple, distance: float) -> bool:
    """Whether the point of a surface where a ray enters it, in the solid's frame, is in a patch."""
    x, y, z = (
        origin[0] + distance * ray[0],
        origin[1] + distance * ray[1],
        origin[2] + distance * ray[2],
    )
    axis, side, height, radius = patch
    along, across = (x, y) if axis == 0.0 else (y, x)
    return side * along >= height and across * across + z * z <= radius * radius


@compiled
def _direction(level: Triple, slope: Triple, z: float) -> Triple:
    """Direction of a line of sight of slope ``z``, see ``_interval``."""
    return level[0] + slope[0] * z, level[1] + slope[1] * z, level[2] + slope[2] * z


@compiled
def _interval(
    kind: float,
    halves: Triple,
    origin: Triple,
    level: Triple,
    slope: Triple,
    bottom: float,
    up: float,
    samples: int,
) -> tuple[int, int]:
    """The first line of sight of a column that meets a solid, and the one after the last.

    Solids are convex: lines that meet one are next to each other. Without any the two are the same.

    Args:
        kind, halves, origin: as of ``_entered``.
        level: the direction of the line of slope 0, in the solid's frame.
        slope: by how much directions change with the slope.
        bottom: slope at which the column begins.
        up: distance of the lines, in slopes.
        samples: how many there are.
    """
    start, end = 0, samples
    while start < end:
        z = bottom + (start + 0.5) * up
        if _entered(kind, halves, origin, _direction(level, slope, z)) < math.inf:
            break
        start += 1
    while start < end - 1:
        z = bottom + (end - 0.5) * up
        if _entered(kind, halves, origin, _direction(level, slope, z)) < math.inf:
            break
        end -= 1
    return start, end


@compiled
def _scanned(
    views: Floats, window: Window, samples: int, patch: Patch
) -> tuple[int, float, float, Triple, Window]:
    """Number of lines of sight in a window that meet a patch of the first solid, unhidden.

    Also the mean and the mean products of their slopes, and between which they lie. The loops hand
    no arrays to other functions, which would cost more than all else in them.
    """
    left, right, bottom, top = window
    across, up = (right - left) / samples, (top - bottom) / samples
    hits, mean_y, mean_z = 0, 0.0, 0.0
    square_y, product, square_z = 0.0, 0.0, 0.0
    least_y, most_y, least_z, most_z = math.inf, -math.inf, math.inf, -math.inf
    first = views[0]
    kind, halves = first[0], (first[1], first[2], first[3])
    origin, slope = (first[4], first[5], first[6]), (first[13], first[14], first[15])
    whole, before = patch[3] == math.inf, np.empty(len(views), np.intp)
    for column in range(samples):
        y = left + (column + 0.5) * across
        level = first[7] + first[10] * y, first[8] + first[11] * y, first[9] + first[12] * y
        start, end = _interval(kind, halves, origin, level, slope, bottom, up, samples)
        # Those of the others that may be before it here.
        others = 0
        for index in range(1, len(views)):
            if views[index, 16] <= y <= views[index, 17]:
                before[others] = index
                others += 1
        for row in range(start, end):
            z, seen, distance = bottom + (row + 0.5) * up, True, math.inf
            if others > 0 or not whole:
                ray = _direction(level, slope, z)
                distance = _entered(kind, halves, origin, ray)
                seen = _within(patch, origin, ray, distance)
            for other in range(others):
                if not seen:
                    break
                index = before[other]
                if views[index, 18] <= z <= views[index, 19]:
                    met = _entered(
                        views[index, 0],
                        (views[index, 1], views[index, 2], views[index, 3]),
                        (views[index, 4], views[index, 5], views[index, 6]),
                        (
                            views[index, 7] + views[index, 10] * y + views[index, 13] * z,
                            views[index, 8] + views[index, 11] * y + views[index, 14] * z,
                            views[index, 9] + views[index, 12] * y + views[index, 15] * z,
                        ),
                    )
                    seen = not met < distance
            if seen:
                hits += 1
                mean_y += y
                mean_z += z
                square_y += y * y
                product += y * z
                square_z += z * z
                least_y, most_y = min(least_y, y), max(most_y, y)
                least_z, most_z = min(least_z, z), max(most_z, z)
    ends = (least_y - across / 2, most_y + across / 2, least_z - up / 2, most_z + up / 2)
    count = max(hits, 1)
    products = (square_y / count, product / count, square_z / count)
    return hits, mean_y / count, mean_z / count, products, ends


@compiled
def _silhouette(
    views: Floats, window: Window, samples: int, patch: Patch, lens: Floats, shapes: Floats
) -> None:
    """Silhouette of the first of some solids in a window, as ``silhouettes`` has it."""
    focal = lens[0]
    aside, above = 0.5 * lens[1] / focal, 0.5 * lens[2] / focal
    # The outermost pixel belongs to a region that covers its centre.
    rim_y, rim_z = aside - 0.5 / focal, above - 0.5 / focal
    left, right, bottom, top = window
    hits, y, z, products, ends = _scanned(views, window, samples, patch)
    if hits > 0:
        area = hits * (right - left) * (top - bottom) / samples**2
        shapes[0] = area * focal * focal
        shapes[1] = focal * (aside - y)
        shapes[2] = focal * (above - z)
        sideways = ends[0] <= -rim_y or ends[1] >= rim_y
        shapes[3] = sideways or ends[2] <= -rim_z or ends[3] >= rim_z
        # A line of sight stands for a cell, which has a variance of its own.
        across, up = (right - left) / samples, (top - bottom) / samples
        shapes[4] = focal * focal * (products[0] - y * y + across * across / 12.0)
        shapes[5] = focal * focal * (products[1] - y * z)
        shapes[6] = focal * focal * (products[2] - z * z + up * up / 12.0)


@compiled_once
def silhouettes(
    things: Floats,
    parts: Floats,
    carriers: Rows,
    placements: Floats,
    targets: Rows,
    patches: Floats,
    cameras: Floats,
    rows: Rows,
    lenses: Floats,
    shapes: Floats,
) -> bool:
    """Find what pinhole cameras see of solids, which all of them, and parts of links, may hide.

    Args:
        things: the solids, shape (k, 16).
        parts: of links, in their frames, shape (m, 16).
        carriers: rows of the links that carry them, shape (m,).
        placements: of links, as ``Engine`` has them, shape (links, 12).
        targets: which of the solids are looked at, and lines of sight each way across the part of
            its frame that is in the image, shape (n, 2).
        patches: the part of each target's surface that is looked at, shape (n, 4): whether it is
            around the axis x (0) or y (1), towards which end of it (1 or -1), from which height
            on along it and within which radius of it, m; ``WHOLE`` for all of the surface.
        cameras: their placements, with the axes ahead, left and up, among others, shape (n, 12).
        rows: which of these are the cameras', shape (c,).
        lenses: focal length, width and height of each camera's image, px, shape (c, 3).
        shapes: takes visible area, px; column and row of its centroid, px; 1 where it touches the
            image's border; and variance of the columns, covariance and variance of the rows, px^2;
            zeros where nothing is seen; shape (c, n, SHAPE).

    Returns:
        Whether anything is seen.
    """
    seen = False
    solids = np.empty((len(things) + len(parts), WIDTH))
    for index in range(len(things)):
        for i in range(WIDTH):
            solids[index, i] = things[index, i]
    attached = False
    views = np.empty((len(solids), 22))
    for which in range(len(rows)):
        camera, lens = cameras[rows[which]], lenses[which]
        # Slopes at the image's border.
        aside, above = 0.5 * lens[1] / lens[0], 0.5 * lens[2] / lens[0]
        for index in range(len(targets)):
            target, samples = targets[index, 0], targets[index, 1]
            for i in range(SHAPE):
                shapes[which, index, i] = 0.0
            _view(solids[target], camera, views[0])
            left, right = max(views[0, 16], -aside), min(views[0, 17], aside)
            bottom, top = max(views[0, 18], -above), min(views[0, 19], above)
            if left >= right or bottom >= top:
                continue
            if not attached:
                attach(parts, placements, carriers, solids[len(things) :])
                attached = True
            window = (left, right, bottom, top)
            count = _relevant(solids, camera, target, window, views)
            patch = (patches[index, 0], patches[index, 1], patches[index, 2], patches[index, 3])
            _silhouette(views[:count], window, samples, patch, lens, shapes[which, index])
            seen |= shapes[which, index, 0] > 0.0
    return seen


@compiled_once
def unhidden(
    things: Floats,
    parts: Floats,
    carriers: Rows,
    placements: Floats,
    target: int,
    camera: Floats,
    slopes: Floats,
    seen: Booleans,
) -> None:
    """Find at which of some lines of sight a solid is seen.

    Args:
        things, parts, carriers, placements: as of ``silhouettes``.
        target: which of the things it is.
        camera: its placement, shape (12,).
        slopes: of the lines, y / x and z / x, shape (k, 2).
        seen: becomes whether the solid is seen there, shape (k,).
    """
    solids = np.empty((len(things) + len(parts), WIDTH))
    for index in range(len(things)):
        for i in range(WIDTH):
            solids[index, i] = things[index, i]
    attach(parts, placements, carriers, solids[len(things) :])
    views = np.empty((len(solids), 22))
    _view(solids[target], camera, views[0])
    window = (slopes[:, 0].min(), slopes[:, 0].max(), slopes[:, 1].min(), slopes[:, 1].max())
    count = _relevant(solids, camera, target, window, views)
    for index in range(len(slopes)):
        y, z = slopes[index, 0], slopes[index, 1]
        hits, _, _, _, _ = _scanned(views[:count], (y, y, z, z), 1, WHOLE)
        seen[index] = hits > 0

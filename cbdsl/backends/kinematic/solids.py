"""Balls, boxes and cylinders as rows of one array: how far off they are and what they hide.

A row holds the shape's number, half its extents along its own axes, m, its position, m, and its
axes as columns of a rotation, row by row; all in the world frame. Cylinders stand along their z.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.kinematic.compiled import compiled, compiled_once

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

BALL, BOX, CYLINDER = 0.0, 1.0, 2.0
WIDTH = 16
HALVES, POSITION, ROTATION = slice(1, 4), slice(4, 7), slice(7, 16)

_NEAREST = 0.02
"""What is nearer to a camera than this is not seen, m."""


@compiled
def _into(solid: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector of the world frame in the solid's axes."""
    return (
        solid[7] * x + solid[10] * y + solid[13] * z,
        solid[8] * x + solid[11] * y + solid[14] * z,
        solid[9] * x + solid[12] * y + solid[15] * z,
    )


@compiled
def _outside(solid: Floats, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Signed distance of a point, in the solid's frame, and the outward normal there."""
    if solid[0] == BALL:
        far = math.sqrt(x * x + y * y + z * z)
        if far == 0.0:
            return -solid[1], 0.0, 0.0, 1.0
        return far - solid[1], x / far, y / far, z / far
    if solid[0] == CYLINDER:
        far = math.sqrt(x * x + y * y)
        ux, uy = (x / far, y / far) if far > 0.0 else (1.0, 0.0)
        a, c = far - solid[1], abs(z) - solid[3]
        up = math.copysign(1.0, z)
        if a > 0.0 and c > 0.0:
            d = math.hypot(a, c)
            return d, ux * a / d, uy * a / d, up * c / d
        if a > c:
            return a, ux, uy, 0.0
        return c, 0.0, 0.0, up
    a, b, c = abs(x) - solid[1], abs(y) - solid[2], abs(z) - solid[3]
    if max(a, b, c) > 0.0:
        vx = math.copysign(max(a, 0.0), x)
        vy = math.copysign(max(b, 0.0), y)
        vz = math.copysign(max(c, 0.0), z)
        d = math.sqrt(vx * vx + vy * vy + vz * vz)
        return d, vx / d, vy / d, vz / d
    if a >= b and a >= c:
        return a, math.copysign(1.0, x), 0.0, 0.0
    if b >= c:
        return b, 0.0, math.copysign(1.0, y), 0.0
    return c, 0.0, 0.0, math.copysign(1.0, z)


@compiled_once
def depths(
    solids: Floats, placements: Floats, rows: Rows, centres: Floats, radii: Floats
) -> Floats:
    """How deep balls are inside solids, and which way is out.

    Args:
        solids: shape (k, 16).
        placements: of links, as ``Tree`` has them, shape (links, 12).
        rows: of the links that carry the balls, shape (n,).
        centres: of the balls in their links' frames, m, shape (n, 3).
        radii: of the balls, m, shape (n,).

    Returns:
        Shape (n, k, 7): depth, m, negative where they do not touch; the solid's outward unit
        normal; and the ball's centre in the world frame, m.
    """
    found = np.empty((len(rows), len(solids), 7))
    for i in range(len(rows)):
        place, centre = placements[rows[i]], centres[i]
        x, y, z = (
            place[9] + place[0] * centre[0] + place[1] * centre[1] + place[2] * centre[2],
            place[10] + place[3] * centre[0] + place[4] * centre[1] + place[5] * centre[2],
            place[11] + place[6] * centre[0] + place[7] * centre[1] + place[8] * centre[2],
        )
        for j in range(len(solids)):
            solid, own = solids[j], found[i, j]
            a, b, c = _into(solid, x - solid[4], y - solid[5], z - solid[6])
            distance, u, v, w = _outside(solid, a, b, c)
            own[0] = radii[i] - distance
            own[1] = solid[7] * u + solid[8] * v + solid[9] * w
            own[2] = solid[10] * u + solid[11] * v + solid[12] * w
            own[3] = solid[13] * u + solid[14] * v + solid[15] * w
            own[4], own[5], own[6] = x, y, z
    return found


@compiled_once
def attached(parts: Floats, placements: Floats, rows: Rows) -> Floats:
    """Solids that are given in their links' frames, shape (k, 16), in the world frame.

    Args:
        parts: shape (k, 16).
        placements: of links, as ``Tree`` has them, shape (links, 12).
        rows: of the links that carry them, shape (k,).
    """
    found = parts.copy()
    for index in range(len(parts)):
        part, own, place = parts[index], found[index], placements[rows[index]]
        for i in range(3):
            own[4 + i] = place[9 + i]
            for k in range(3):
                own[4 + i] += place[3 * i + k] * part[4 + k]
                own[7 + 3 * i + k] = (
                    place[3 * i] * part[7 + k]
                    + place[3 * i + 1] * part[10 + k]
                    + place[3 * i + 2] * part[13 + k]
                )
    return found


@compiled
def _slab(origin: float, direction: float, half: float) -> tuple[float, float]:
    """Where a ray is between two planes."""
    if direction == 0.0:
        return (-math.inf, math.inf) if abs(origin) <= half else (math.inf, -math.inf)
    near, far = (-half - origin) / direction, (half - origin) / direction
    return (near, far) if near <= far else (far, near)


@compiled
def _round(a: float, b: float, c: float) -> tuple[float, float]:
    """Where a t^2 + 2 b t + c is not positive."""
    root = b * b - a * c
    if root < 0.0 or a == 0.0:
        return (-math.inf, math.inf) if a == 0.0 and c <= 0.0 else (math.inf, -math.inf)
    root = math.sqrt(root)
    return (-b - root) / a, (-b + root) / a


@compiled
def _entered(solid: Floats, origin: Floats, u: float, v: float, w: float) -> float:
    """How far along a ray, in the solid's frame, it enters the solid; infinite if it does not."""
    x, y, z = origin[0], origin[1], origin[2]
    if solid[0] == BALL:
        square = x * x + y * y + z * z - solid[1] * solid[1]
        near, far = _round(u * u + v * v + w * w, u * x + v * y + w * z, square)
    else:
        near, far = _slab(z, w, solid[3])
        if solid[0] == CYLINDER:
            square = x * x + y * y - solid[1] * solid[1]
            enter, leave = _round(u * u + v * v, u * x + v * y, square)
            near, far = max(near, enter), min(far, leave)
        else:
            for axis, half in ((0, solid[1]), (1, solid[2])):
                enter, leave = _slab(origin[axis], u if axis == 0 else v, half)
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
def _frame(solid: Floats, centre: Floats, axes: Floats) -> tuple[float, float, float, float]:
    """Slopes within which a solid is seen: (left, right, bottom, top) as y / x and z / x.

    ``centre`` and ``axes`` are the solid's in the camera's frame.
    """
    radius = solid[1]
    if solid[0] != BALL:
        radius = math.sqrt(solid[1] ** 2 + solid[2] ** 2 + solid[3] ** 2)
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
        x = centre[0] + axes[0, 0] * a + axes[0, 1] * b + axes[0, 2] * c
        y = (centre[1] + axes[1, 0] * a + axes[1, 1] * b + axes[1, 2] * c) / x
        z = (centre[2] + axes[2, 0] * a + axes[2, 1] * b + axes[2, 2] * c) / x
        left, right = min(left, y), max(right, y)
        bottom, top = min(bottom, z), max(top, z)
    return left, right, bottom, top


@compiled
def _seen(
    solids: Floats,
    placed: tuple[Floats, Floats, Floats],
    chosen: Rows,
    y: float,
    z: float,
) -> bool:
    """Whether a line of sight (1, y, z) of the camera meets the first chosen solid first."""
    origins, axes, frames = placed
    distance = math.inf
    for turn in range(len(chosen)):
        index = chosen[turn]
        frame, turned = frames[index], axes[index]
        near = math.inf
        if frame[0] <= y <= frame[1] and frame[2] <= z <= frame[3]:
            near = _entered(
                solids[index],
                origins[index],
                turned[0, 0] + turned[1, 0] * y + turned[2, 0] * z,
                turned[0, 1] + turned[1, 1] * y + turned[2, 1] * z,
                turned[0, 2] + turned[1, 2] * y + turned[2, 2] * z,
            )
        if turn == 0:
            distance = near
            if near == math.inf:
                return False
        elif near < distance:
            return False
    return True


@compiled
def _placed(solids: Floats, position: Floats, rotation: Floats) -> tuple[Floats, Floats, Floats]:
    """Solids as a camera has them.

    Its origin in each solid's frame, shape (k, 3); each solid's axes in the camera's frame, shape
    (k, 3, 3); and, shape (k, 6), the slopes within which each is seen, and how far ahead it begins
    and ends.
    """
    count = len(solids)
    origins, axes, frames = np.empty((count, 3)), np.empty((count, 3, 3)), np.empty((count, 6))
    centre = np.empty(3)
    for index in range(count):
        solid = solids[index]
        x, y, z = solid[4] - position[0], solid[5] - position[1], solid[6] - position[2]
        origins[index] = _into(solid, -x, -y, -z)
        for i in range(3):
            centre[i] = rotation[0, i] * x + rotation[1, i] * y + rotation[2, i] * z
            for j in range(3):
                axes[index, i, j] = (
                    rotation[0, i] * solid[7 + j]
                    + rotation[1, i] * solid[10 + j]
                    + rotation[2, i] * solid[13 + j]
                )
        frames[index, :4] = _frame(solid, centre, axes[index])
        radius = math.sqrt(solid[1] ** 2 + solid[2] ** 2 + solid[3] ** 2)
        frames[index, 4], frames[index, 5] = centre[0] - radius, centre[0] + radius
    return origins, axes, frames


@compiled
def _chosen(frames: Floats, target: int, window: tuple[float, float, float, float]) -> Rows:
    """A solid, and then all that may be before it in a window of slopes."""
    left, right, bottom, top = window
    chosen = np.empty(len(frames), np.intp)
    chosen[0], count = target, 1
    for index in range(len(frames)):
        frame = frames[index]
        aside = frame[0] > right or frame[1] < left or frame[2] > top or frame[3] < bottom
        if index != target and not aside and frame[4] < frames[target, 5]:
            chosen[count] = index
            count += 1
    return chosen[:count]


@compiled
def _scanned(
    solids: Floats,
    placed: tuple[Floats, Floats, Floats],
    chosen: Rows,
    window: tuple[float, float, float, float],
    samples: int,
) -> tuple[int, float, float, tuple[float, float, float, float]]:
    """How many lines of sight in a window meet the first chosen solid; their mean and bounds."""
    left, right, bottom, top = window
    across, up = (right - left) / samples, (top - bottom) / samples
    hits, columns, rows = 0, 0.0, 0.0
    least_y, most_y, least_z, most_z = math.inf, -math.inf, math.inf, -math.inf
    for i in range(samples):
        y = left + (i + 0.5) * across
        for j in range(samples):
            z = bottom + (j + 0.5) * up
            if _seen(solids, placed, chosen, y, z):
                hits += 1
                columns += y
                rows += z
                least_y, most_y = min(least_y, y), max(most_y, y)
                least_z, most_z = min(least_z, z), max(most_z, z)
    bounds = (
        least_y - 0.5 * across,
        most_y + 0.5 * across,
        least_z - 0.5 * up,
        most_z + 0.5 * up,
    )
    return hits, columns / max(hits, 1), rows / max(hits, 1), bounds


@compiled_once
def silhouettes(
    solids: Floats,
    samples: Rows,
    position: Floats,
    rotation: Floats,
    lens: tuple[float, float, float],
) -> Floats:
    """What a pinhole camera sees of the first solids, which all of them may hide.

    Args:
        solids: shape (k, 16).
        samples: for each of the first n solids, lines of sight each way across the part of its
            frame that is in the image, shape (n,).
        position: of the camera, m, shape (3,).
        rotation: the camera's axes as columns: ahead, left and up, shape (3, 3).
        lens: focal length, width and height of the image, px.

    Returns:
        Shape (n, 4): visible area, px; column and row of its centroid, px; and 1 where it touches
        the image's border.
    """
    focal = lens[0]
    # Slopes at the image's border.
    aside, above = 0.5 * lens[1] / focal, 0.5 * lens[2] / focal
    # The outermost pixel belongs to a region that covers its centre.
    rim_y, rim_z = aside - 0.5 / focal, above - 0.5 / focal
    found = np.zeros((len(samples), 4))
    placed = _placed(solids, position, rotation)
    for target in range(len(samples)):
        frame = placed[2][target]
        left, right = max(frame[0], -aside), min(frame[1], aside)
        bottom, top = max(frame[2], -above), min(frame[3], above)
        if left >= right or bottom >= top:
            continue
        window = (left, right, bottom, top)
        chosen = _chosen(placed[2], target, window)
        hits, y, z, bounds = _scanned(solids, placed, chosen, window, samples[target])
        if hits > 0:
            area = hits * (right - left) * (top - bottom) / samples[target] ** 2
            found[target, 0] = area * focal * focal
            found[target, 1] = focal * (aside - y)
            found[target, 2] = focal * (above - z)
            sideways = bounds[0] <= -rim_y or bounds[1] >= rim_y
            found[target, 3] = sideways or bounds[2] <= -rim_z or bounds[3] >= rim_z
    return found

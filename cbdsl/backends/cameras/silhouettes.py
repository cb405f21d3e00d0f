"""Silhouettes: the visible parts of solids, and the occlusions among solids."""

from __future__ import annotations

import math

import numpy as np

from cbdsl.backends.cameras.ray import Triple, direction_at, entered, met_rows
from cbdsl.backends.cameras.solid_view import VIEW, Window, view_of, views_before
from cbdsl.backends.staging.solids import WIDTH, attach
from cbdsl.numeric.arrays import Booleans, Floats, Integers, Rows
from cbdsl.numeric.compiled import compiled, compiled_once

Patch = tuple[float, float, float, float]

#: Patch of a whole surface.
WHOLE = (0.0, 1.0, -math.inf, math.inf)

#: Number of values that describe a silhouette.
SHAPE = 7


@compiled
def _within(patch: Patch, origin: Triple, ray: Triple, distance: float) -> bool:
    """Return whether a ray enters a solid within a patch, in the solid's frame."""
    x, y, z = (
        origin[0] + distance * ray[0],
        origin[1] + distance * ray[1],
        origin[2] + distance * ray[2],
    )
    axis, side, height, radius = patch
    along, across = (x, y) if axis == 0.0 else (y, x)
    return side * along >= height and across * across + z * z <= radius * radius


@compiled
def _scan(views: Floats, window: Window, samples: int, patch: Patch, seen_at: Booleans) -> bool:
    """Find the lines of sight in a window that meet a patch of the first solid unoccluded.

    The loops pass no arrays to other functions, since that takes longer than all other work here.

    Args:
        seen_at: Output: whether each line does, shape (samples, samples) or larger.

    Returns:
        Whether others occlude a part of the solid.
    """
    left, right, bottom, top = window
    across, up = (right - left) / samples, (top - bottom) / samples
    hides = False
    first = views[0]
    kind, halves = first[0], (first[1], first[2], first[3])
    origin, slope = (first[4], first[5], first[6]), (first[13], first[14], first[15])
    whole, before = patch[3] == math.inf, np.empty(len(views), np.intp)
    for column in range(samples):
        y = left + (column + 0.5) * across
        level = first[7] + first[10] * y, first[8] + first[11] * y, first[9] + first[12] * y
        start, end = met_rows(kind, halves, origin, level, slope, bottom, up, samples)
        # Other solids that may occlude the first in this column.
        others = 0
        for index in range(1, len(views)):
            if views[index, 16] <= y <= views[index, 17]:
                before[others] = index
                others += 1
        for row in range(samples):
            seen_at[column, row] = False
        for row in range(start, end):
            z, seen, distance = bottom + (row + 0.5) * up, True, math.inf
            if others > 0 or not whole:
                ray = direction_at(level, slope, z)
                distance = entered(kind, halves, origin, ray)
                seen = _within(patch, origin, ray, distance)
            for other in range(others):
                if not seen:
                    break
                index = before[other]
                if views[index, 18] <= z <= views[index, 19]:
                    met = entered(
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
                    hides |= not seen
            seen_at[column, row] = seen
    return hides


@compiled
def _sum(
    window: Window, samples: int, seen_at: Booleans
) -> tuple[int, float, float, Triple, Window]:
    """Return the number of lines of sight in a window that see the solid.

    Also return the mean and the mean products of their slopes, and the bounds of the slopes.
    """
    left, right, bottom, top = window
    across, up = (right - left) / samples, (top - bottom) / samples
    hits, mean_y, mean_z = 0, 0.0, 0.0
    square_y, product, square_z = 0.0, 0.0, 0.0
    least_y, most_y, least_z, most_z = math.inf, -math.inf, math.inf, -math.inf
    for column in range(samples):
        y = left + (column + 0.5) * across
        for row in range(samples):
            if seen_at[column, row]:
                z = bottom + (row + 0.5) * up
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
    views: Floats,
    window: Window,
    samples: int,
    patch: Patch,
    lens: Floats,
    seen_at: Booleans,
    shapes: Floats,
) -> None:
    """Write the silhouette of the first of some solids in a window, as in ``silhouettes``."""
    focal = lens[0]
    aside, above = 0.5 * lens[1] / focal, 0.5 * lens[2] / focal
    # A region includes the outermost pixel if it covers the pixel's centre.
    rim_y, rim_z = aside - 0.5 / focal, above - 0.5 / focal
    left, right, bottom, top = window
    # The image of an unoccluded convex solid is connected. So components are searched only behind
    # occluders.
    if _scan(views, window, samples, patch, seen_at):
        keep_largest(seen_at, samples)
    hits, y, z, products, ends = _sum(window, samples, seen_at)
    if hits > 0:
        area = hits * (right - left) * (top - bottom) / samples**2
        shapes[0] = area * focal * focal
        shapes[1] = focal * (aside - y)
        shapes[2] = focal * (above - z)
        sideways = ends[0] <= -rim_y or ends[1] >= rim_y
        shapes[3] = sideways or ends[2] <= -rim_z or ends[3] >= rim_z
        # A line of sight stands for a cell, whose own variance is added.
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
    """Find the silhouettes of solids for pinhole cameras, with occlusion by solids and links.

    If another solid cuts a silhouette in two, the larger part counts.

    Args:
        things: Solids, shape (k, 16).
        parts: Parts of links, in the frames of the links, shape (m, 16).
        carriers: Rows of the links that carry the parts, shape (m,).
        placements: Placements of the links, as in ``Engine``, shape (links, 12).
        targets: Index of each target among the solids, and number of lines of sight in each
            direction across the part of its frame that is in the image, shape (n, 2).
        patches: Searched part of each target's surface, shape (n, 4): axis x (0) or y (1), end of
            the axis (1 or -1), least height along it and largest radius about it, m; ``WHOLE`` for
            the whole surface.
        cameras: Placements that include the cameras', with axes ahead, left and up, shape (n, 12).
        rows: Rows of the cameras in these placements, shape (c,).
        lenses: Focal length, width and height of each camera's image, px, shape (c, 3).
        shapes: Output, shape (c, n, SHAPE): visible area, px; column and row of its centroid, px; 1
            if it touches the image's border; variance of the columns, covariance and variance of
            the rows, px^2; zeros if the target is not visible.

    Returns:
        Whether any target is visible.
    """
    seen = False
    solids = np.empty((len(things) + len(parts), WIDTH))
    for index in range(len(things)):
        for i in range(WIDTH):
            solids[index, i] = things[index, i]
    attached = False
    views = np.empty((len(solids), VIEW))
    finest = targets[:, 1].max() if len(targets) > 0 else 0
    seen_at = np.empty((finest, finest), np.bool_)
    for which in range(len(rows)):
        camera, lens = cameras[rows[which]], lenses[which]
        # Slopes at the image's border.
        aside, above = 0.5 * lens[1] / lens[0], 0.5 * lens[2] / lens[0]
        for index in range(len(targets)):
            target, samples = targets[index, 0], targets[index, 1]
            for i in range(SHAPE):
                shapes[which, index, i] = 0.0
            view_of(solids[target], camera, views[0])
            left, right = max(views[0, 16], -aside), min(views[0, 17], aside)
            bottom, top = max(views[0, 18], -above), min(views[0, 19], above)
            if left >= right or bottom >= top:
                continue
            # Links are placed only if a target is in some image.
            if not attached:
                attach(parts, placements, carriers, solids[len(things) :])
                attached = True
            window = (left, right, bottom, top)
            count = views_before(solids, camera, target, window, views)
            patch = (patches[index, 0], patches[index, 1], patches[index, 2], patches[index, 3])
            shape = shapes[which, index]
            _silhouette(views[:count], window, samples, patch, lens, seen_at, shape)
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
    """Find the lines of sight at which a solid is visible.

    Args:
        things, parts, carriers, placements: Arguments of ``silhouettes``.
        target: Index of the solid among the things.
        camera: Placement of the camera, shape (12,).
        slopes: Slopes of the lines, y / x and z / x, shape (k, 2).
        seen: Output: whether the solid is visible along each line, shape (k,).
    """
    solids = np.empty((len(things) + len(parts), WIDTH))
    for index in range(len(things)):
        for i in range(WIDTH):
            solids[index, i] = things[index, i]
    attach(parts, placements, carriers, solids[len(things) :])
    views = np.empty((len(solids), VIEW))
    view_of(solids[target], camera, views[0])
    window = (slopes[:, 0].min(), slopes[:, 0].max(), slopes[:, 1].min(), slopes[:, 1].max())
    count = views_before(solids, camera, target, window, views)
    one = np.empty((1, 1), np.bool_)
    for index in range(len(slopes)):
        y, z = slopes[index, 0], slopes[index, 1]
        _scan(views[:count], (y, y, z, z), 1, WHOLE, one)
        seen[index] = one[0, 0]


@compiled
def keep_largest(seen: Booleans, size: int) -> None:
    """Keep only the largest component; cells connect by sides or corners.

    Args:
        seen: Visible cells, of which the first ``size`` in each direction count, shape (n, n).
        size: Number of cells in each direction, at most n.
    """
    # The queue cannot overflow, because a cell gets its label when it is queued, and so is queued
    # once.
    labels, queue = np.zeros((size, size), np.int64), np.empty((size * size, 2), np.int64)
    largest, most, count = 0, 0, 0
    for column in range(size):
        for row in range(size):
            if seen[column, row] and labels[column, row] == 0:
                count += 1
                area = _flood(seen, size, column, row, count, labels, queue)
                if area > most:
                    largest, most = count, area
    # Most silhouettes are connected, and need no second pass.
    if count > 1:
        for column in range(size):
            for row in range(size):
                seen[column, row] = labels[column, row] == largest


@compiled
def _flood(
    seen: Booleans, size: int, column: int, row: int, label: int, labels: Integers, queue: Integers
) -> int:
    """Label all cells of the component of one cell; return their number."""
    labels[column, row] = label
    queue[0, 0], queue[0, 1] = column, row
    first, end = 0, 1
    while first < end:
        here, there = queue[first, 0], queue[first, 1]
        first += 1
        for i in range(max(here - 1, 0), min(here + 2, size)):
            for k in range(max(there - 1, 0), min(there + 2, size)):
                if seen[i, k] and labels[i, k] == 0:
                    labels[i, k] = label
                    queue[end, 0], queue[end, 1] = i, k
                    end += 1
    return end

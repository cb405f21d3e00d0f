"""Box whose silhouettes in several images have the areas and second moments of seen regions.

The camera is taken as affine at the centre of the box. The silhouette of a box is then a hexagon,
the Minkowski sum of the images a, b and c of its edges, sorted by angle. Three parallelograms tile
it: (a, b) at -c/2 from the centre, (b, c) at -a/2, and (a, c) at b/2. Two images give eight
measurements for four unknowns: three edges and the heading, which is known modulo a quarter turn.
Each heading of a grid is fitted by Gauss-Newton in the logarithms of the edges.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_HEADINGS = np.linspace(0.0, math.pi / 2, 30, endpoint=False)
_STEPS, _LARGEST_STEP, _DIFFERENCE = 6, 0.5, 1e-4
# Errors of areas and moments as shares, and of the logarithms of edges about their mean.
_AREA, _MOMENT, _EDGES = 0.02, 0.01, 2.0


class SeenBox(NamedTuple):
    """Box that was fitted to silhouettes.

    Attributes:
        heading: Direction of the first edge about the vertical, rad, from about 0 to pi/2.
        edges: First, second and vertical edge, m, shape (3,).
        contrast: Median of the grid's costs over the least one; about 1 for round objects.
    """

    heading: float
    edges: Floats
    contrast: float


def fit_box(jacobians: Floats, silhouettes: Floats) -> SeenBox:
    """Return the upright box with given silhouettes.

    Args:
        jacobians: Change of image coordinates per motion of a point, 1/m, shape (k, 2, 3).
        silhouettes: Area, and moments along the first axis, mixed, and along the second axis, of
            each silhouette in image coordinates, shape (k, 4).
    """
    size = math.sqrt(silhouettes[:, 0].mean() / np.linalg.norm(jacobians, 2, (1, 2)).mean() ** 2)
    logs = np.full((len(_HEADINGS), 3), math.log(size))
    nudges = _DIFFERENCE * np.eye(3)
    for _ in range(_STEPS):
        errors = _errors(jacobians, silhouettes, logs)
        slopes = [(_errors(jacobians, silhouettes, logs + each) - errors) for each in nudges]
        slope = np.stack(slopes, axis=-1) / _DIFFERENCE
        normal = np.einsum("nri,nrj->nij", slope, slope) + 1e-9 * np.eye(3)
        step = np.linalg.solve(normal, np.einsum("nri,nr->ni", slope, errors)[..., None])
        logs = logs - np.clip(step[..., 0], -_LARGEST_STEP, _LARGEST_STEP)
    costs = np.square(_errors(jacobians, silhouettes, logs)).sum(axis=-1)
    best = int(costs.argmin())
    before, least, after = costs[best - 1], costs[best], costs[(best + 1) % len(costs)]
    # The minimum of the parabola through three neighbours.
    bend = before - 2 * least + after
    shift = 0.5 * (before - after) / bend if bend > 0 else 0.0
    heading = _HEADINGS[best] + shift * _HEADINGS[1]
    contrast = float((np.median(costs) + 1) / (least + 1))
    return SeenBox(float(heading), np.exp(logs[best]), contrast)


def _errors(jacobians: Floats, silhouettes: Floats, logs: Floats) -> Floats:
    """Return the weighted errors of the boxes of all headings, shape (n, r)."""
    seen = hexagons(jacobians, _HEADINGS, np.exp(logs))
    areas = np.log(seen[..., 0] / silhouettes[:, 0]) / _AREA
    spread = (silhouettes[:, 1] + silhouettes[:, 3])[:, None]
    moments = (seen[..., 1:] - silhouettes[:, 1:]) / spread / _MOMENT
    unequal = (logs - logs.mean(axis=-1, keepdims=True)) / _EDGES
    return np.concatenate([areas, moments.reshape(len(logs), -1), unequal], axis=-1)


def hexagons(jacobians: Floats, headings: Floats, edges: Floats) -> Floats:
    """Return the areas and moments of the silhouettes of boxes, shape (n, k, 4).

    Args:
        jacobians: Change of image coordinates per motion of a point, 1/m, shape (k, 2, 3).
        headings: Heading of each box, rad, shape (n,).
        edges: Edges of each box, m, shape (n, 3).
    """
    cos, sin, none = np.cos(headings), np.sin(headings), np.zeros_like(headings)
    rows = [[cos, sin, none], [-sin, cos, none], [none, none, none + 1.0]]
    axes = np.moveaxis(np.array(rows), -1, 0) * edges[..., None]
    images = np.einsum("kij,ngj->nkgi", jacobians, axes)
    images = images * np.where(images[..., 1] < 0.0, -1.0, 1.0)[..., None]
    order = np.argsort(np.arctan2(images[..., 1], images[..., 0]), axis=-1)
    a, b, c = np.moveaxis(np.take_along_axis(images, order[..., None], axis=-2), -2, 0)
    areas, moments = np.zeros(a.shape[:-1]), np.zeros((*a.shape, 2))
    for one, other, aside in ((a, b, c), (b, c, a), (a, c, b)):
        area = np.abs(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
        spread = (_square(one) + _square(other)) / 12 + _square(aside) / 4
        areas, moments = areas + area, moments + area[..., None, None] * spread
    moments = moments / areas[..., None, None]
    return np.stack([areas, moments[..., 0, 0], moments[..., 0, 1], moments[..., 1, 1]], axis=-1)


def _square(vectors: Floats) -> Floats:
    """Return the products of vectors with themselves, shape (..., 2, 2)."""
    square: Floats = vectors[..., :, None] * vectors[..., None, :]
    return square

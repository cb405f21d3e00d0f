"""Rays and convex solids: entry points of lines of sight."""

# Model: a ray is origin + t * direction, in the solid's frame. A solid is an intersection of
# intervals of t: a slab |z| <= half gives linear bounds, a round side gives the quadratic
#     a t^2 + 2 b t + c <= 0
# with its two roots as bounds. A ball is one quadratic, a cylinder a slab and a quadratic in x and
# y, and a box three slabs. The ray enters at the largest lower bound, unless an upper bound is
# smaller. Directions are not normalised, so that t is comparable among solids of one line of sight:
# all of its directions in the solids' frames are rotations of the same vector.

from __future__ import annotations

import math

from cbdsl.backends.staging.solids import BALL, CYLINDER
from cbdsl.numeric.compiled import compiled

Triple = tuple[float, float, float]


@compiled
def _slab(origin: float, direction: float, half: float) -> tuple[float, float]:
    """Return the interval of a ray between two planes."""
    # The ray is parallel to both planes: it is between them everywhere or nowhere.
    if direction == 0.0:
        return (-math.inf, math.inf) if abs(origin) <= half else (math.inf, -math.inf)
    near, far = (-half - origin) / direction, (half - origin) / direction
    return (near, far) if near <= far else (far, near)


@compiled
def _round(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the interval in which a t^2 + 2 b t + c is not positive."""
    root = b * b - a * c
    # With a = 0 the ray is parallel to the axis of a cylinder, for example a camera straight above
    # a can.
    if root < 0.0 or a == 0.0:
        return (-math.inf, math.inf) if a == 0.0 and c <= 0.0 else (math.inf, -math.inf)
    root = math.sqrt(root)
    return (-b - root) / a, (-b + root) / a


@compiled
def entered(kind: float, halves: Triple, origin: Triple, direction: Triple) -> float:
    """Return the distance along a ray, in a solid's frame, to its entry; infinite without one."""
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
    # A camera inside of a solid does not see it, since its entry is behind the camera.
    return near if 0.0 < near <= far else math.inf


@compiled
def direction_at(level: Triple, slope: Triple, z: float) -> Triple:
    """Return the direction of a line of sight of slope ``z``; see ``met_rows``."""
    return level[0] + slope[0] * z, level[1] + slope[1] * z, level[2] + slope[2] * z


@compiled
def met_rows(
    kind: float,
    halves: Triple,
    origin: Triple,
    level: Triple,
    slope: Triple,
    bottom: float,
    up: float,
    samples: int,
) -> tuple[int, int]:
    """Return the range of a column's lines of sight that meet a solid: first index and end index.

    Solids are convex, so lines that meet one are adjacent. If none does, the two are equal.

    Args:
        kind: Kind of the solid, as in ``entered``.
        halves: Half extents of the solid, as in ``entered``.
        origin: Camera position, as in ``entered``.
        level: Direction of the line of slope 0, in the solid's frame.
        slope: Change of the direction per slope.
        bottom: Slope at which the column begins.
        up: Distance of the lines, in slopes.
        samples: Number of lines.
    """
    start, end = 0, samples
    while start < end:
        z = bottom + (start + 0.5) * up
        if entered(kind, halves, origin, direction_at(level, slope, z)) < math.inf:
            break
        start += 1
    while start < end - 1:
        z = bottom + (end - 0.5) * up
        if entered(kind, halves, origin, direction_at(level, slope, z)) < math.inf:
            break
        end -= 1
    return start, end

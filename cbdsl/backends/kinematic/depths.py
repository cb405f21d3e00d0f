"""Depths of balls inside solids."""

# Model: the signed distance d of a ball's centre from a solid, negative inside, gives the depth
# r - d of a ball with the radius r. Outside, d is the distance to the nearest point of the solid.
# Inside, it is that to the nearest side, whose normal is taken. The ball's deepest point is its
# centre plus r times the inward normal.
# Assumption: a ball is small against the solid. The normal jumps to the other side if a ball's
# centre passes the middle of a thin plate.

from __future__ import annotations

import math

from cbdsl.backends.staging.solids import BALL, CYLINDER, into
from cbdsl.numeric.arrays import Floats, Rows
from cbdsl.numeric.compiled import compiled, compiled_once


@compiled
def _outside(solid: Floats, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return the signed distance of a point, in the solid's frame, and its outward normal."""
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
    solids: Floats, placements: Floats, carriers: Rows, balls: Floats, contacts: Floats
) -> bool:
    """Find the depths of balls inside solids, and the inward normals.

    Args:
        solids: Rows of the solids, shape (k, 16).
        placements: Placements of the links, as in ``Engine``, shape (links, 12).
        carriers: Rows of the links that carry the balls, shape (n,).
        balls: Centres of the balls in these links' frames, m, and radii, m, shape (n, 4).
        contacts: Output, shape (n, k, 7): depth, m, negative without contact; the ball's deepest
            point, m, and the unit normal into the solid there, both in the world frame.

    Returns:
        Whether any ball touches any solid.
    """
    touching = False
    for i in range(len(balls)):
        place, ball = placements[carriers[i]], balls[i]
        x, y, z = (
            place[9] + place[0] * ball[0] + place[1] * ball[1] + place[2] * ball[2],
            place[10] + place[3] * ball[0] + place[4] * ball[1] + place[5] * ball[2],
            place[11] + place[6] * ball[0] + place[7] * ball[1] + place[8] * ball[2],
        )
        for j in range(len(solids)):
            solid, own = solids[j], contacts[i, j]
            a, b, c = into(solid, x - solid[4], y - solid[5], z - solid[6])
            distance, u, v, w = _outside(solid, a, b, c)
            own[0] = ball[3] - distance
            touching |= own[0] > 0.0
            own[4] = -(solid[7] * u + solid[8] * v + solid[9] * w)
            own[5] = -(solid[10] * u + solid[11] * v + solid[12] * w)
            own[6] = -(solid[13] * u + solid[14] * v + solid[15] * w)
            own[1] = x + ball[3] * own[4]
            own[2] = y + ball[3] * own[5]
            own[3] = z + ball[3] * own[6]
    return touching

"""Boxes that fill closed surfaces: how much of them, and nothing else."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.box_cover import cover


def cuboid(low: tuple[float, ...], high: tuple[float, ...], *, inward: bool = False) -> Floats:
    """Return triangles of a cuboid's surface, shape (12, 3, 3)."""
    ends, faces = np.array([low, high]), []
    for axis, end in itertools.product(range(3), range(2)):
        square = np.empty((4, 3))
        for number, (u, v) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
            square[number, axis] = ends[end, axis]
            square[number, (axis + 1) % 3] = ends[u, (axis + 1) % 3]
            square[number, (axis + 2) % 3] = ends[v, (axis + 2) % 3]
        square = square[::-1] if (end == 0) != inward else square
        faces += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return np.array(faces)


def ball(radius: float, steps: int = 24) -> Floats:
    """Return triangles of a ball's surface, shape (n, 3, 3)."""
    down, around = np.linspace(0, np.pi, steps), np.linspace(0, 2 * np.pi, 2 * steps + 1)
    at = radius * np.stack(
        [
            np.sin(down)[:, None] * np.cos(around),
            np.sin(down)[:, None] * np.sin(around),
            np.cos(down)[:, None] * np.ones_like(around),
        ],
        axis=-1,
    )
    faces = []
    for i, k in itertools.product(range(steps - 1), range(2 * steps)):
        a, b, c, d = at[i, k], at[i + 1, k], at[i + 1, k + 1], at[i, k + 1]
        faces += [[a, b, c], [a, c, d]]
    return np.array(faces)


def test_cuboid_is_one_box() -> None:
    found = cover(cuboid((0.1, -0.2, 0.0), (0.3, 0.1, 0.08)), 16)
    assert found.share == 1.0
    ((centre, edges),) = found.boxes
    assert centre == pytest.approx([0.2, -0.05, 0.04])
    assert edges == pytest.approx([0.2, 0.3, 0.08])


def test_cavity_stays_free() -> None:
    """Walls of 2 cm around it are six boxes."""
    outer = cuboid((0, 0, 0), (0.16, 0.16, 0.16))
    inner = cuboid((0.02, 0.02, 0.02), (0.14, 0.14, 0.14), inward=True)
    found = cover(np.concatenate([outer, inner]), 16)
    assert found.share == 1.0 and len(found.boxes) == 6
    assert np.prod(found.boxes[:, 1], axis=1).sum() == pytest.approx(0.16**3 - 0.12**3)
    for centre, edges in found.boxes:
        assert np.any(np.abs(centre - 0.08) - edges / 2 >= 0.06 - 1e-9), "in a wall"


def test_more_boxes_fill_more_of_a_ball_and_stay_inside() -> None:
    shares = []
    for most in (1, 4, 16):
        found = cover(ball(0.05), most)
        shares.append(found.share)
        assert len(found.boxes) == most
        corners = np.abs(found.boxes[:, 0]) + found.boxes[:, 1] / 2
        assert np.linalg.norm(corners, axis=1).max() < 0.05 + 0.1 / 32
    assert shares[0] < shares[1] < shares[2]
    assert shares[0] == pytest.approx(8 / 3**1.5 / (4 * np.pi / 3), abs=0.07), "a cube in a ball"
    assert shares[2] > 0.75


def test_part_thinner_than_a_cell_is_not_filled() -> None:
    thin = cuboid((0, 0, 0), (0.2, 0.2, 1e-4))
    found = cover(np.concatenate([thin, cuboid((0, 0, 0.1), (0.2, 0.2, 0.2))]), 16)
    (box,) = found.boxes
    assert box[1] == pytest.approx([0.2, 0.2, 0.1], abs=0.01)

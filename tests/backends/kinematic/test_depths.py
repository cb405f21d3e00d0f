"""How deep balls are in solids, against the definition, and how low solids reach."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.kinematic.depths import depths
from cbdsl.backends.staging.solids import solid_row
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from tests.backends.kinematic.shapes import SHAPES, inside, turned


def one(solid: Floats, point: Floats, radius: float = 0.0) -> Floats:
    """Return the row of ``depths`` for a ball, in a link that is the world."""
    world = np.array([[1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]])
    found = np.empty((1, 1, 7))
    ball = np.array([[*point, radius]])
    touches = depths(solid[None], world, np.zeros(1, np.intp), ball, found)
    assert touches == (found[0, 0, 0] > 0.0)
    return found[0, 0]


@pytest.mark.parametrize("name", SHAPES)
def test_step_of_the_distance_along_the_normal_leads_to_the_surface(name: str) -> None:
    rng = np.random.default_rng(0)
    shape = SHAPES[name]
    for _ in range(50):
        pose = Pose(rng.normal(size=3), turned(rng))
        point = pose.position + rng.uniform(-0.2, 0.2, size=3)
        found = one(solid_row(shape, pose), point)
        depth, normal = found[0], -found[4:]
        assert np.linalg.norm(normal) == pytest.approx(1)
        assert found[1:4] == pytest.approx(point)
        thick = one(solid_row(shape, pose), point, radius=0.01)
        assert thick[0] == pytest.approx(depth + 0.01)
        assert thick[1:4] == pytest.approx(point - 0.01 * normal)
        surface = point + depth * normal
        for step, expected in ((1e-6, False), (-1e-6, True)):
            local = pose.rotation.T @ (surface + step * normal - pose.position)
            assert inside(shape, local[None])[0] == expected
        # No part of the solid is nearer than that.
        ways = rng.standard_normal((50, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        around = point + 0.999 * abs(depth) * ways
        local = (around - pose.position) @ pose.rotation
        assert (inside(shape, local) == (depth > 0)).all()


@pytest.mark.parametrize("name", SHAPES)
def test_lowest_point_of_a_turned_shape(name: str) -> None:
    shape = SHAPES[name]
    rng = np.random.default_rng(2)
    surface = rng.uniform(-0.15, 0.15, size=(200_000, 3))
    surface = surface[inside(shape, surface)]
    rotation = turned(rng)
    assert shape.depth(rotation) == pytest.approx(-(surface @ rotation.T)[:, 2].min(), abs=0.006)
    assert shape.depth(np.eye(3)) == pytest.approx(shape.half_height)

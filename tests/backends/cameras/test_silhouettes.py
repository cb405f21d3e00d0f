"""Silhouettes of solids in a camera, against rays through every pixel."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from cbdsl.backends.cameras.silhouettes import SHAPE, WHOLE, silhouettes
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.backends.staging.solids import WIDTH, solid_row
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from tests.backends.kinematic.shapes import SHAPES, inside, turned

LENS = (418.5, 320.0, 240.0)
HERE, AHEAD = np.zeros(3), np.eye(3)


def seen(*solids: Floats, samples: int = 64, patch: Sequence[float] = WHOLE) -> Floats:
    """Return the moments of the first solid, or of a patch of it, in a camera at the origin."""
    world = np.array([[*AHEAD.ravel(), *HERE]])
    first, found = np.array([[0, samples]]), np.empty((1, 1, SHAPE))
    nothing, patches, lenses = np.empty((0, WIDTH)), np.array([patch]), np.array([LENS])
    free, eyes = (nothing, np.empty(0, np.intp)), np.zeros(1, np.intp)
    silhouettes(np.array(solids), *free, world, first, patches, world, eyes, lenses, found)
    # Parts of a link that is the world hide the same as solids.
    parts = np.array(solids[1:]).reshape(-1, WIDTH), np.zeros(len(solids) - 1, np.intp)
    hidden = np.empty((1, 1, SHAPE))
    silhouettes(solids[0][None], *parts, world, first, patches, world, eyes, lenses, hidden)
    assert (hidden == found).all()
    return found[0, 0]


@pytest.mark.parametrize("name", SHAPES)
def test_silhouette_contains_exactly_the_rays_that_hit_the_shape(name: str) -> None:
    """Compare with the marching of rays through every pixel."""
    rng = np.random.default_rng(1)
    focal, width, height = LENS
    shape = SHAPES[name]
    for _ in range(3):
        pose = Pose(np.array([0.6, *rng.uniform(-0.05, 0.05, size=2)]), turned(rng))
        columns, rows = np.meshgrid(np.arange(0.5, width), np.arange(0.5, height))
        lines = np.stack(
            [np.ones_like(rows), (width / 2 - columns) / focal, (height / 2 - rows) / focal], -1
        ).reshape(-1, 3)
        mask = np.zeros(len(lines), dtype=bool)
        for ahead in np.arange(0.48, 0.72, 0.004):
            mask |= inside(shape, (ahead * lines - pose.position) @ pose.rotation)
        area, column, row, clipped, *moments = seen(solid_row(shape, pose))
        assert area == pytest.approx(mask.sum(), rel=0.03)
        assert column == pytest.approx(columns.ravel()[mask].mean(), abs=0.7)
        assert row == pytest.approx(rows.ravel()[mask].mean(), abs=0.7)
        assert not clipped
        spread = np.cov(columns.ravel()[mask], rows.ravel()[mask])
        scale = np.trace(spread)
        wanted = spread[0, 0], spread[0, 1], spread[1, 1]
        assert moments == pytest.approx(wanted, abs=0.03 * scale)


@pytest.mark.parametrize(
    ("axis", "name"), [(0.0, "ball"), (1.0, "ball"), (0.0, "box"), (1.0, "box")]
)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_patch_is_seen_from_its_side_alone_and_round(axis: float, side: float, name: str) -> None:
    shape, radius, distance = SHAPES[name], 0.02, 2.0
    half = shape.halves[int(axis)]
    height = math.sqrt(half**2 - radius**2) if name == "ball" else half
    outward = side * np.eye(3)[int(axis)]
    for facing in (True, False):
        turn = (0.0 if axis else 0.5 * math.pi) + (0.0 if side > 0 else math.pi)
        rotation = Pose.turned(np.array([0.0, 0.0, 1.0]), turn + 0.5 * math.pi).rotation
        rotation = rotation if facing else np.diag([-1.0, -1.0, 1.0]) @ rotation
        assert (rotation @ outward)[0] == pytest.approx(-1 if facing else 1)
        solid = solid_row(shape, Pose(np.array([distance, 0.0, 0.0]), rotation))
        row = seen(solid, samples=200, patch=(axis, side, height - 1e-9, radius))
        wanted = math.pi * (LENS[0] * radius / (distance - height)) ** 2 if facing else 0.0
        assert row[0] == pytest.approx(wanted, rel=0.05)


def test_silhouette_at_the_border_is_clipped() -> None:
    border = LENS[1] / 2 / LENS[0]
    ball = SolidShape.ball(0.05)
    for aside, whole in ((border - 0.07, True), (border - 0.03, False), (border, False)):
        row = seen(solid_row(ball, Pose(np.array([1.0, aside, 0.0]), AHEAD)))
        assert row[3] != whole
        assert row[0] > 0
    assert not seen(solid_row(ball, Pose(np.array([1.0, border + 0.1, 0.0]), AHEAD))).any()
    assert not seen(solid_row(ball, Pose(np.array([-1.0, 0.0, 0.0]), AHEAD))).any()


def test_object_in_front_occludes_and_object_behind_does_not() -> None:
    ball = solid_row(SolidShape.ball(0.05), Pose(np.array([1.0, 0.0, 0.0]), AHEAD))
    board = SolidShape("box", (0.001, 0.1, 0.1))
    free = seen(ball)
    half = seen(ball, solid_row(board, Pose(np.array([0.8, 0.1, 0.0]), AHEAD)))
    assert half[0] == pytest.approx(free[0] / 2, rel=0.02)
    assert half[1] > free[1] + 5, "its right half is left, and columns count to the right"
    assert not seen(ball, solid_row(board, Pose(np.array([0.8, 0.0, 0.0]), AHEAD))).any()
    assert seen(ball, solid_row(board, Pose(np.array([1.2, 0.0, 0.0]), AHEAD))) == pytest.approx(
        free
    )


@pytest.mark.parametrize("name", SHAPES)
def test_support_occludes_an_object_only_from_below(name: str) -> None:
    shape = SHAPES[name]
    tilted = Pose.turned(np.array([0.0, 1.0, 0.0]), 0.5).rotation
    place = Pose(np.array([1.0, 0.0, 0.0]), AHEAD)
    for side in (1.0, -1.0):
        # The board's top is just below the object if the camera looks at it from above.
        down = -side * tilted.T[2]
        board = SolidShape("box", (0.3, 0.3, 0.01))
        below = place.position + (shape.half_height + 0.01) * down
        solid = solid_row(shape, Pose(place.position, tilted))
        free = seen(solid)
        row = seen(solid, solid_row(board, Pose(below, tilted)))
        above = float((HERE - below) @ -down) > 0.01
        assert (row == free).all() if above else row[0] < 0.5 * free[0]


def test_silhouette_of_a_ball_has_its_angular_size() -> None:
    area = seen(
        solid_row(SolidShape.ball(0.05), Pose(np.array([1.0, 0.0, 0.0]), AHEAD)), samples=24
    )[0]
    tangent = math.tan(math.asin(0.05))
    assert area == pytest.approx(math.pi * (LENS[0] * tangent) ** 2, rel=0.01)

"""Harmonic fields: their properties in theory, over scenes in one to three dimensions."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.potentials.field import HarmonicField, NoPathError
from cbdsl.control.potentials.grid import Grid
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats
from tests.control.scenes import SCENES, Scene, cluttered, cube

FIELDS = {name: scene.field() for name, scene in SCENES.items()}


def follow(field: HarmonicField, start: Floats, goal: Floats) -> list[Floats]:
    """Return the descent by steps of 0.4 cells, or of the remaining distance if it is less."""
    path = [start]
    for _ in range(40 * max(field.grid.shape)):
        left = float(np.linalg.norm(goal - path[-1]))
        if left < 1e-9:
            break
        step = min(0.4 * field.grid.spacing, left)
        path.append(path[-1] + step * field.slope(path[-1], goal).direction)
    return path


@pytest.mark.parametrize("name", SCENES)
def test_only_the_vertices_of_the_goal_are_minima(name: str) -> None:
    u, scene = FIELDS[name].u, SCENES[name]
    best = np.max([np.roll(u, step, axis) for axis in range(u.ndim) for step in (-1, 1)], axis=0)
    free = u > 0.0
    free[scene.grid.nearest(scene.goal)] = False
    assert free.any()
    assert (best > u)[free].all()


@pytest.mark.parametrize("name", SCENES)
def test_vertex_of_a_solved_field_is_the_mean_of_its_neighbours(name: str) -> None:
    u, scene = FIELDS[name].u, SCENES[name]
    mean = np.mean([np.roll(u, step, axis) for axis in range(u.ndim) for step in (-1, 1)], axis=0)
    free = u > 0.0
    free[scene.grid.nearest(scene.goal)] = False
    np.testing.assert_allclose(mean[free], u[free], rtol=2e-5)


@pytest.mark.parametrize("name", SCENES)
def test_ways_from_anywhere_end_at_the_goal_and_keep_clear(
    name: str, rng: np.random.Generator
) -> None:
    scene, field = SCENES[name], FIELDS[name]
    for start in scene.starts(6, rng):
        path = follow(field, start, scene.goal)
        assert np.linalg.norm(path[-1] - scene.goal) < 1e-9
        for obstacle in scene.obstacles:
            assert min(obstacle.distance(point) for point in path) > -1e-9


@pytest.mark.parametrize("name", SCENES)
def test_potential_is_between_0_and_1_and_falls_along_the_way(
    name: str, rng: np.random.Generator
) -> None:
    scene, field = SCENES[name], FIELDS[name]
    for start in scene.starts(2, rng):
        slopes = [field.slope(point, scene.goal) for point in follow(field, start, scene.goal)]
        assert all(0.0 <= slope.potential <= 1.0 for slope in slopes)
        closeness = np.array([slope.closeness for slope in slopes])
        assert (np.diff(closeness) > 0).mean() > 0.9
        assert slopes[-1].potential < 1e-7
    for point in rng.uniform(-0.5, 1.5, (50, len(scene.goal))):
        slope = field.slope(point, scene.goal)
        assert 0.0 <= slope.potential <= 1.0
        assert np.linalg.norm(slope.direction) == pytest.approx(1.0)


@pytest.mark.parametrize("name", SCENES)
def test_direction_equals_the_negative_gradient(name: str, rng: np.random.Generator) -> None:
    scene, field = SCENES[name], FIELDS[name]
    small = 1e-5 * scene.grid.spacing
    for point in scene.starts(20, rng):
        if np.linalg.norm(point - scene.goal) < 2.01 * scene.grid.spacing:
            continue
        changes = [
            field.slope(point + e, scene.goal).closeness
            - field.slope(point - e, scene.goal).closeness
            for e in small * np.eye(len(point))
        ]
        direction = np.array(changes) / np.linalg.norm(changes)
        np.testing.assert_allclose(field.slope(point, scene.goal).direction, direction, atol=1e-4)


@pytest.mark.parametrize("name", SCENES)
def test_direction_outside_of_free_cells_leads_into_them(
    name: str, rng: np.random.Generator
) -> None:
    scene, field = SCENES[name], FIELDS[name]
    centres = [0.5 * (obstacle.lower + obstacle.upper) for obstacle in scene.obstacles]
    for start in [*centres[:3], *(1.0 + rng.uniform(0.0, 0.3, (2, len(scene.goal))))]:
        assert np.linalg.norm(follow(field, start, scene.goal)[-1] - scene.goal) < 1e-9


def test_field_in_one_dimension_is_linear() -> None:
    grid, goal = cube(1, 20), np.array([0.5])
    field = HarmonicField(grid, (), goal)
    for x in (0.2, 0.33, 0.61, 0.85):
        wanted = abs(x - 0.5) / 0.5
        assert field.slope(np.array([x]), goal).potential == pytest.approx(wanted, abs=0.5 / 20)


def test_mirrored_scenes_have_mirrored_fields() -> None:
    scene = cluttered(3, 16, 2)
    mirror = np.array([-1.0, 1.0, 1.0])
    shift = np.array([1.0, 0.0, 0.0])
    mirrored = [
        Obstacle(
            o.name,
            np.minimum(mirror * o.lower + shift, mirror * o.upper + shift),
            np.maximum(mirror * o.lower + shift, mirror * o.upper + shift),
            o.radius,
        )
        for o in scene.obstacles
    ]
    other = HarmonicField(scene.grid, mirrored, mirror * scene.goal + shift)
    np.testing.assert_allclose(scene.field().u, other.u[::-1], rtol=1e-3)


def test_finer_grids_converge() -> None:
    box = Obstacle("box", np.array([0.5, 0.25]), np.array([0.75, 0.5]))
    goal, points = np.array([0.25, 0.25]), np.array([[0.75, 0.75], [0.25, 0.75], [0.875, 0.25]])

    def ratios(cells: int) -> Floats:
        field = HarmonicField(cube(2, cells), [box], goal)
        at = np.array([field.slope(point, goal).closeness for point in points])
        return np.asarray(np.log(at / at[0])[1:])

    finest = ratios(256)
    errors = [float(np.abs(ratios(cells) - finest).max()) for cells in (16, 32, 64)]
    assert errors[1] < 0.7 * errors[0]
    assert errors[2] < 0.7 * errors[1]


@pytest.mark.parametrize("name", SCENES)
def test_potential_is_continuous_towards_the_goal(name: str, rng: np.random.Generator) -> None:
    scene, field = SCENES[name], FIELDS[name]
    ray = rng.normal(size=len(scene.goal))
    ray *= scene.grid.spacing / np.linalg.norm(ray)
    slopes = [field.slope(scene.goal + s * ray, scene.goal) for s in np.linspace(0.01, 3, 1000)]
    potentials = np.array([slope.potential for slope in slopes])
    directions = np.array([slope.direction for slope in slopes])
    assert potentials[0] < 0.02
    assert np.abs(np.diff(potentials)).max() < 0.01
    assert np.abs(np.diff(directions, axis=0)).max() < 0.05


def test_potential_far_from_the_goal_keeps_its_precision() -> None:
    u = FIELDS["narrow maze"].u
    assert 0.0 < u[u > 0].min() < 1e-30 * u.max()


@pytest.mark.parametrize("name", ["cluttered square", "cluttered cube", "maze"])
def test_warm_solutions_are_the_same_and_take_fewer_cycles(name: str) -> None:
    scene, before = SCENES[name], FIELDS[name]
    first, *others = scene.obstacles
    moved = (first._replace(upper=first.upper + 1.01 * scene.grid.spacing), *others)
    changed = Scene(scene.grid, moved, scene.goal)
    cold, warm = changed.field(), changed.field(before)
    assert warm.cycles < cold.cycles
    np.testing.assert_allclose(warm.u, cold.u, rtol=1e-3)
    assert scene.field(before).cycles < 0.25 * before.cycles


def test_field_suits_goals_nearby_only() -> None:
    scene, field = SCENES["empty cube"], FIELDS["empty cube"]
    spacing = scene.grid.spacing
    assert field.suits(scene.goal)
    vertex = scene.grid.position(scene.grid.nearest(scene.goal) or ())
    assert field.suits(vertex + 0.6 * spacing)
    assert not field.suits(vertex + spacing * np.array([0.8, 0.0, 0.0]))


WALL = Obstacle("the wall", np.array([0.4, 0.0]), np.array([0.5, 1.0]))
CAGE = (
    Obstacle("north", np.array([0.6, 0.8]), np.array([0.9, 0.8])),
    Obstacle("south", np.array([0.6, 0.5]), np.array([0.9, 0.5])),
    Obstacle("west", np.array([0.6, 0.5]), np.array([0.6, 0.8])),
    Obstacle("east", np.array([0.9, 0.5]), np.array([0.9, 0.8])),
)


@pytest.mark.parametrize(
    ("obstacles", "goal", "start", "message"),
    [
        ((WALL,), [0.45, 0.5], [0.1, 0.1], "the goal is inside the wall"),
        ((WALL,), [0.51, 0.5], [0.1, 0.1], "the goal is less than a cell away from the wall"),
        ((), [0.5, 1.5], [0.1, 0.1], "the goal is outside the workspace"),
        (
            (),
            [0.5, 1.0],
            [0.1, 0.1],
            "the goal is less than a cell away from the workspace's border",
        ),
        ((WALL,), [0.8, 0.5], [0.1, 0.5], "it is enclosed by the workspace's border and the wall"),
        (CAGE, [0.7, 0.7], [0.1, 0.5], "the goal is enclosed by north and south and west and east"),
        (CAGE, [0.1, 0.5], [0.7, 0.7], "it is enclosed by north and south and west and east"),
    ],
)
def test_unreachable_goal_raises_no_path(
    obstacles: tuple[Obstacle, ...], goal: list[float], start: list[float], message: str
) -> None:
    grid = Grid.between(np.zeros(2), np.ones(2), 0.05)
    with pytest.raises(NoPathError, match=message):
        HarmonicField(grid, obstacles, np.array(goal)).slope(np.array(start), np.array(goal))

"""Scenes that harmonic fields are tested in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbdsl.control.potentials.field import HarmonicField
from cbdsl.control.potentials.grid import FREE, Grid
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats


@dataclass(frozen=True)
class Scene:
    """The unit cube in n dimensions, with obstacles and a goal."""

    grid: Grid
    obstacles: tuple[Obstacle, ...]
    goal: Floats

    def field(self, start: HarmonicField | None = None) -> HarmonicField:
        return HarmonicField(self.grid, self.obstacles, self.goal, start)

    def starts(self, count: int, rng: np.random.Generator) -> Floats:
        """Return random points of the cells that are connected with the goal."""
        vertex = self.grid.nearest(self.goal)
        assert vertex is not None
        cells = np.argwhere(self.grid.connected(self.grid.owners(self.obstacles) == FREE, vertex))
        chosen = cells[rng.integers(len(cells), size=count)]
        return self.grid.position((0,) * cells.shape[1]) + self.grid.spacing * (
            chosen + rng.uniform(-0.49, 0.49, chosen.shape)
        )


def cube(n: int, cells: int) -> Grid:
    return Grid.between(np.zeros(n), np.ones(n), 1.0 / cells)


def cluttered(n: int, cells: int, seed: int) -> Scene:
    """Return a scene of balls and boxes, and a goal beside them."""
    rng = np.random.default_rng([n, seed])
    goal = rng.uniform(0.2, 0.8, n)
    obstacles: list[Obstacle] = []
    while len(obstacles) < 3 * n and n > 1:
        lower = rng.uniform(0.0, 0.9, n)
        upper = lower if len(obstacles) % 2 else lower + rng.uniform(0.05, 0.2, n)
        obstacle = Obstacle(f"thing {len(obstacles)}", lower, upper, float(rng.uniform(0.01, 0.1)))
        if obstacle.distance(goal) > 2.0 / cells:
            obstacles.append(obstacle)
    return Scene(cube(n, cells), tuple(obstacles), goal)


def maze(n: int, cells: int, walls: int = 4) -> Scene:
    """Return a scene of thin walls that are open on one side and the other in turn."""
    obstacles = []
    for i in range(1, walls + 1):
        lower, upper = np.zeros(n), np.ones(n)
        lower[0] = upper[0] = i / (walls + 1)
        lower[1], upper[1] = (0.25, 1.0) if i % 2 else (0.0, 0.75)
        obstacles.append(Obstacle(f"wall {i}", lower, upper))
    return Scene(cube(n, cells), tuple(obstacles), np.full(n, 0.1))


SCENES = {
    "line": cluttered(1, 20, 0),
    "empty square": Scene(cube(2, 24), (), np.array([0.31, 0.72])),
    "cluttered square": cluttered(2, 32, 1),
    "maze": maze(2, 30),
    "narrow maze": maze(2, 40, walls=11),
    "empty cube": Scene(cube(3, 16), (), np.array([0.3, 0.6, 0.52])),
    "cluttered cube": cluttered(3, 20, 1),
    "maze in a cube": maze(3, 20),
}

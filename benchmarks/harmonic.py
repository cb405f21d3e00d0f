"""Harmonic functions on cubes with a dozen balls: multigrid against a direct solution.

The direct solution is SciPy's SuperLU on the same equations, with the ordering for symmetric
matrices, or with SciPy's default one (``--ordering COLAMD``). It runs in a process of its own with
bounded time and memory; if it reaches a bound, the ratio is larger than the printed one. If pyamg
is installed, algebraic multigrid is measured as well. Multigrid stops if every vertex is the mean
of its neighbours up to 1e-5 of its own value. Warm solutions start from that of a scene with the
goal or one ball displaced by a cell. The direct solution takes minutes for 64 cells along each
axis; ``--direct`` selects another number.

    python benchmarks/harmonic.py
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import resource
import statistics
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from time import perf_counter
from typing import Any

import numpy as np

from cbdsl.control.potentials.field import HarmonicField
from cbdsl.control.potentials.grid import FREE, Grid
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats

GOAL = np.full(3, 0.31)
# The first is for symmetric matrices, and by far the better one here; the other is SciPy's default.
ORDERINGS = ["MMD_AT_PLUS_A", "COLAMD"]


class Scene:
    """The unit cube with balls in it, on a grid of ``cells`` along each axis."""

    def __init__(self, cells: int, balls: int = 12) -> None:
        rng = np.random.default_rng(0)
        self.grid = Grid.between(np.zeros(3), np.ones(3), 1.0 / cells)
        self.obstacles: list[Obstacle] = []
        while len(self.obstacles) < balls:
            centre, radius = rng.uniform(0.1, 0.9, 3), float(rng.uniform(0.05, 0.12))
            if np.linalg.norm(centre - GOAL) > radius + 0.15:
                self.obstacles.append(Obstacle.sphere("ball", centre, radius))

    def field(self, start: HarmonicField | None = None) -> HarmonicField:
        """Return the solution, as a complete field."""
        return HarmonicField(self.grid, self.obstacles, GOAL, start)

    def moved_goal(self) -> Floats:
        """Return the goal one cell farther."""
        moved: Floats = GOAL + np.array([self.grid.spacing, 0.0, 0.0])
        return moved

    def moved_obstacles(self) -> list[Obstacle]:
        """Return the obstacles, one of them shifted by one cell."""
        first, *others = self.obstacles
        shift = np.array([0.0, self.grid.spacing, 0.0])
        return [first._replace(lower=first.lower + shift, upper=first.upper + shift), *others]

    def equations(self) -> tuple[Any, Floats]:
        """Return matrix and right side of the same problem, for the free vertices."""
        from scipy import sparse

        # Discrete Laplace equation at each free vertex i, with the source b at the goal:
        #     6 u_i - sum over free neighbours j of u_j = b_i
        # Vertices of obstacles and of the border have u = 0, so that their terms vanish.
        free = self.grid.owners(self.obstacles) == FREE
        number = np.full(free.shape, -1)
        number[free] = np.arange(free.sum())
        rows, columns = [], []
        for axis in range(3):
            ahead = np.moveaxis(number, axis, 0)
            # Each pair of free neighbours occurs once; the transpose adds the other half of the
            # matrix.
            both = (ahead[:-1] >= 0) & (ahead[1:] >= 0)
            rows.append(ahead[:-1][both])
            columns.append(ahead[1:][both])
        i, j = np.concatenate(rows), np.concatenate(columns)
        size = int(free.sum())
        half = sparse.coo_matrix((np.full(len(i), -1.0), (i, j)), (size, size))
        source = np.zeros(size)
        vertex = self.grid.nearest(GOAL)
        assert vertex is not None
        source[number[vertex]] = 1.0
        return (half + half.T + 6.0 * sparse.identity(size)).tocsc(), source


def seconds(work: Callable[[], object]) -> float:
    """Return the duration of a call, s."""
    start = perf_counter()
    work()
    return perf_counter() - start


def growth(sizes: list[int], repeats: int) -> dict[str, Any]:
    """Return medians over rounds that each solve every size, and the exponent of their growth."""
    scenes = {cells: Scene(cells) for cells in sizes}
    times: dict[int, list[float]] = {cells: [] for cells in sizes}
    for _ in range(repeats):
        for cells, scene in scenes.items():
            times[cells].append(seconds(scene.field))
    medians = {cells: statistics.median(values) for cells, values in times.items()}
    vertices = [math.prod(scenes[cells].grid.shape) for cells in sizes]
    # The slope over logarithms is the exponent; a method of linear cost has an exponent of 1.
    exponent, _ = np.polyfit(np.log(vertices), np.log(list(medians.values())), 1)
    return {
        "seconds": {str(cells): round(value, 4) for cells, value in medians.items()},
        "exponent": round(float(exponent), 3),
    }


def warm(cells: int, repeats: int) -> dict[str, Any]:
    """Return seconds and cycles from zero, and from a solution with one object a cell elsewhere."""
    scene = Scene(cells)
    before, goal, obstacles = scene.field(), scene.moved_goal(), scene.moved_obstacles()
    cases = {
        "goal moved, from zero": (scene.obstacles, goal, None),
        "goal moved, warm": (scene.obstacles, goal, before),
        "ball moved, from zero": (obstacles, GOAL, None),
        "ball moved, warm": (obstacles, GOAL, before),
    }
    times: dict[str, list[float]] = {case: [] for case in cases}
    cycles = {}
    for _ in range(repeats):
        for case, (balls, place, start) in cases.items():
            began = perf_counter()
            cycles[case] = HarmonicField(scene.grid, balls, place, start).cycles
            times[case].append(perf_counter() - began)
    return {
        case: {"seconds": round(statistics.median(times[case]), 4), "cycles": cycles[case]}
        for case in cases
    }


def direct(
    cells: int, repeats: int, orderings: list[str], limit: float, memory: float
) -> dict[str, Any]:
    """Compare direct solutions with ours, measured before and after them.

    Args:
        cells: Number of cells along each axis.
        repeats: Number of measurements of ours, before and after.
        orderings: Orderings of the unknowns, by SuperLU's names.
        limit: Most time for each direct solution, s.
        memory: Most memory for it, GB.
    """
    scene = Scene(cells)
    matrix, source = scene.equations()
    # Measurements before and after the direct solutions average out a slow drift of the machine.
    times = [seconds(scene.field) for _ in range(repeats)]
    solved = {each: factorized(matrix, source, each, limit, memory) for each in orderings}
    times += [seconds(scene.field) for _ in range(repeats)]
    u = scene.field().u[scene.grid.owners(scene.obstacles) == FREE]
    ours = statistics.median(times)
    row: dict[str, Any] = {"cells": cells, "multigrid, s": round(ours, 4)}
    for ordering, (theirs, exact) in solved.items():
        row[f"{ordering}, s"] = round(theirs, 3)
        if exact is None:
            row[f"{ordering}, not finished; times faster, more than"] = round(theirs / ours, 1)
            continue
        difference = float(np.max(np.abs(u / exact - 1)))
        row[f"{ordering}, times faster"] = round(theirs / ours, 1)
        row[f"{ordering}, largest difference, share of the value"] = float(f"{difference:.1e}")
    return {**row, **algebraic(matrix, source)}


def factorized(
    matrix: Any, source: Floats, ordering: str, limit: float, memory: float
) -> tuple[float, Floats | None]:
    """Return the time of a direct solution, and the solution, or ``None`` if it failed."""
    context = multiprocessing.get_context("fork")
    receiving, sending = context.Pipe(duplex=False)
    given = (matrix, source, ordering, int(memory * 1e9), sending)
    child = context.Process(target=solve_directly, args=given)
    began = perf_counter()
    child.start()
    # With this copy of the sending end closed, ``recv`` raises ``EOFError`` if the child ends
    # silently.
    sending.close()
    try:
        took, solution = receiving.recv() if receiving.poll(limit) else (limit, None)
    except EOFError:
        # It ran out of memory.
        took, solution = perf_counter() - began, None
    child.kill()
    child.join()
    return took, solution


def solve_directly(
    matrix: Any, source: Floats, ordering: str, memory: int, result: Connection
) -> None:
    """Send the time, s, and the solution; in a process of its own, whose memory is limited."""
    from scipy.sparse.linalg import splu

    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    # The matrix is symmetric and positive definite: its diagonal needs no pivots.
    symmetric = ordering == "MMD_AT_PLUS_A"
    began = perf_counter()
    try:
        factors = splu(
            matrix,
            permc_spec=ordering,
            diag_pivot_thresh=0.0 if symmetric else None,
            options={"SymmetricMode": symmetric},
        )
        solution = factors.solve(source)
        result.send((perf_counter() - began, solution))
    except MemoryError:
        return


def algebraic(matrix: Any, source: Floats) -> dict[str, Any]:
    """Measure pyamg's smoothed aggregation on the same equations, if it is installed."""
    try:
        import pyamg
    except ImportError:
        return {}
    began = perf_counter()
    hierarchy = pyamg.smoothed_aggregation_solver(matrix.tocsr())
    ready = perf_counter()
    hierarchy.solve(source, tol=1e-12, accel="cg")
    return {
        "pyamg, set up, s": round(ready - began, 3),
        "pyamg, solve, s": round(perf_counter() - ready, 3),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--sizes", type=int, nargs="+", default=[32, 48, 64, 96, 128])
    parser.add_argument("--direct", type=int, default=64, help="cells of the direct solution")
    parser.add_argument("--ordering", nargs="+", choices=ORDERINGS, default=ORDERINGS[:1])
    parser.add_argument("--limit", type=float, default=600.0, help="of each direct solution, s")
    parser.add_argument("--memory", type=float, default=8.0, help="of each direct solution, GB")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    row = {
        "growth": growth(options.sizes, options.repeats),
        "warm": warm(64, options.repeats),
        "direct": direct(
            options.direct, options.repeats, options.ordering, options.limit, options.memory
        ),
    }
    if options.json:
        sys.stdout.write(json.dumps(row) + "\n")
        return
    for title, values in row.items():
        sys.stdout.write(f"{title}\n")
        for name, value in values.items():
            sys.stdout.write(f"  {name}: {value}\n")


if __name__ == "__main__":
    main()

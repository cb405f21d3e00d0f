"""A harmonic function on a grid, and the way down from any point to its goal (Eq 3.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.control.grid import BORDER, FREE, Booleans, Grid, Vertex
from cbdsl.control.multigrid import Multigrid, neighbour_sum
from cbdsl.control.obstacle import Obstacle
from cbdsl.control.signal import Floats, SignalError

# Largest residual at a vertex, as a share of 1 - phi there. Next to the flattest saddles of a
# thousand cells, neighbours differ by a hundred times that.
_ACCURACY = 1e-5
# Where 1 - phi is a smaller share of its largest value, it is solved for in units of its own.
_FLOOR = 1e-10
# Below this the numbers themselves lose precision.
_LEAST = 1e-280


class NoPathError(SignalError):
    """No free path leads to the goal; the message says why."""


class Slope(NamedTuple):
    """The field at a point.

    Attributes:
        potential: phi_h, from 0 at the goal to 1 at obstacles.
        closeness: 1 - phi_h, exact where phi_h cannot be told from 1.
        direction: of steepest descent, a unit vector (n,); 0 at the goal.
        depth: inside of an obstacle or the border, how far it is to where a path leads to the goal,
            in cells; 0 elsewhere.
    """

    potential: float
    closeness: float
    direction: Floats
    depth: float = 0.0


class HarmonicField:
    """phi_h: 0 at the goal's vertex, 1 on obstacles and the border, harmonic on the rest.

    What is stored is u, a multiple of 1 - phi_h: the solution for a source at the goal's vertex
    and 0 at obstacles. So a goal that moves changes no equation but only its right side, and the
    tiny differences far from the goal keep all their digits.

    Between vertices u is a quadratic spline with the vertices' values as coefficients: its
    gradient is continuous, and on every grid that is shifted by less than a cell it is harmonic
    like u itself, since it is a mean of shifted copies of u. Within two cells of the goal, where
    nothing is in the way, the field turns into a cone around the goal itself.

    Args:
        grid: the vertices.
        obstacles: what blocks them.
        goal: where the field leads, shape (n,).
        start: a field for a similar scene on the same grid, to begin the solution with.

    Attributes:
        u: at the vertices, of the grid's shape.
        cycles: of multigrid that the solution took.

    Raises:
        NoPathError: the goal is outside the grid, or too close to an obstacle or the border.
    """

    def __init__(
        self,
        grid: Grid,
        obstacles: Sequence[Obstacle],
        goal: Floats,
        start: HarmonicField | None = None,
    ) -> None:
        self.grid = grid
        self._obstacles = tuple(obstacles)
        self._owners = grid.owners(obstacles)
        self._source = self._goal_vertex(goal)
        self._reached = grid.connected(self._owners == FREE, self._source)
        before: Floats | None = None if start is None else start.u
        self.u: Floats
        self.cycles: int
        self.u, self.cycles = solve(self._reached, self._source, before)
        # Room for the spline around any vertex.
        self._padded = np.pad(self.u, 1)
        self._top = self._spline(grid.position(self._source))[0]
        self._shell = 1.0 - self._mean_around(self._source) / self._top

    def suits(self, goal: Floats) -> bool:
        """Whether the field leads to a goal, shape (n,), as it does to the one it was made for."""
        vertex = self.grid.position(self._source)
        near = float(np.abs(goal - vertex).max()) <= 0.75 * self.grid.spacing
        return near and self._sees(vertex, goal)

    def slope(self, point: Floats, goal: Floats) -> Slope:
        """The potential and the way down.

        Inside of an obstacle or the border the way leads out.

        Args:
            point: shape (n,).
            goal: where the field ends; it has to suit the field.

        Raises:
            NoPathError: no free path leads from the point to the goal.
        """
        spacing = self.grid.spacing
        towards = goal - point
        distance = float(np.linalg.norm(towards))
        if distance < 2 * spacing and self._sees(point, goal):
            return self._near(point, towards, distance)
        vertex = self.grid.nearest(point)
        if vertex is not None and self._owners[vertex] == FREE and self.u[vertex] == 0.0:
            raise NoPathError(self._enclosure(vertex))
        value, gradient = self._spline(point)
        if value == 0.0:
            way = self._way_out(point)
            depth = float(np.linalg.norm(way)) / self.grid.spacing
            return Slope(1.0, 0.0, _unit(way), depth)
        closeness = min(value / self._top, 1.0)
        return Slope(1.0 - closeness, closeness, _unit(gradient))

    def _near(self, point: Floats, towards: Floats, distance: float) -> Slope:
        """A cone around the goal, which becomes the harmonic function between one and two cells."""
        cells = distance / self.grid.spacing
        cone = min(cells * self._shell, 1.0)
        straight = _unit(towards)
        if cells <= 1.0:
            return Slope(cone, 1.0 - cone, straight)
        share = (cells - 1.0) ** 2 * (5.0 - 2.0 * cells)  # rises smoothly from 0 to 1
        value, gradient = self._spline(point)
        harmonic = 1.0 - min(value / self._top, 1.0)
        potential = share * harmonic + (1.0 - share) * cone
        direction = _unit(share * _unit(gradient) + (1.0 - share) * straight)
        return Slope(potential, 1.0 - potential, direction)

    def _spline(self, point: Floats) -> tuple[float, Floats]:
        """u and its gradient at a point, the latter in a unit of its own."""
        index = (point - self.grid.lower) / self.grid.spacing
        middle = np.rint(index)
        block = self._block(middle)
        largest = 0.0 if block is None else float(block.max())
        if block is None or largest == 0.0:
            return 0.0, np.zeros(len(point))
        offset = index - middle
        below, above = 0.5 - offset, 0.5 + offset
        weights = np.array([0.5 * below**2, 0.75 - offset**2, 0.5 * above**2]).T
        slopes = np.array([-below, -2.0 * offset, above]).T
        block = block / largest  # squares of what is tiny would vanish
        gradient = [
            _contracted(block, [slopes[a] if a == axis else weights[a] for a in range(len(point))])
            for axis in range(len(point))
        ]
        return largest * _contracted(block, list(weights)), np.array(gradient)

    def _block(self, middle: Floats) -> Floats | None:
        """The values of u around a vertex, 3 along each axis, or ``None`` outside the grid."""
        if (middle < 0).any() or (middle >= self.grid.shape).any():
            return None
        return self._padded[tuple(slice(int(i), int(i) + 3) for i in middle)]

    def _mean_around(self, vertex: Vertex) -> float:
        """The mean of the spline over the vertex's neighbours."""
        here, steps = self.grid.position(vertex), self.grid.spacing * np.eye(len(vertex))
        return float(np.mean([self._spline(here + s)[0] for s in (*steps, *-steps)]))

    def _sees(self, point: Floats, goal: Floats) -> bool:
        """Whether the straight way between nearby points stays in cells that lead to the goal."""
        shares = np.linspace(0.0, 1.0, 17)[:, None]
        return self.grid.holds(self._reached, point + shares * (goal - point))

    def _way_out(self, point: Floats) -> Floats:
        """To the nearest vertex from which a path leads to the goal.

        Vertices are looked at in boxes around the point that grow until nothing outside can be
        nearer: a point is mostly a cell or two inside, while a grid has a hundred thousand.
        """
        grid, reach = self.grid, 2.0
        index = (point - grid.lower) / grid.spacing
        while True:
            first = np.clip(np.floor(index - reach), 0, grid.shape).astype(int)
            last = np.clip(np.ceil(index + reach) + 1, 0, grid.shape).astype(int)
            box = self.u[tuple(map(slice, first, last))]
            ways = grid.lower + grid.spacing * (first + np.argwhere(box > 0.0)) - point
            squares = (ways * ways).sum(axis=1)
            nearest = squares.min(initial=math.inf)
            if nearest <= (reach * grid.spacing) ** 2 or box.size == self.u.size:
                way: Floats = ways[np.argmin(squares)]
                return way
            reach *= 2.0

    def _goal_vertex(self, goal: Floats) -> Vertex:
        for obstacle in self._obstacles:
            if obstacle.distance(goal) <= 0.0:
                raise NoPathError(f"the goal is inside {obstacle.name}")
        vertex = self.grid.nearest(goal)
        if vertex is None:
            raise NoPathError("the goal is outside the workspace")
        owner = int(self._owners[vertex])
        if owner != FREE:
            raise NoPathError(f"the goal is less than a cell away from {self._name(owner)}")
        return vertex

    def _enclosure(self, vertex: Vertex) -> str:
        """Barriers that separate a free vertex from the goal."""
        own = self.grid.connected(self._owners == FREE, vertex)
        if self._reached[vertex]:
            return "the way to the goal is too long and narrow for this spacing"
        is_inner = own.sum() < self._reached.sum()
        inner, what = (own, "it") if is_inner else (self._reached, "the goal")
        around = self._owners[neighbour_sum(inner.astype(float)) > 0.0]
        names = [self._name(int(owner)) for owner in np.unique(around[around != FREE])]
        return f"no free path leads to the goal: {what} is enclosed by {' and '.join(names)}"

    def _name(self, owner: int) -> str:
        return "the workspace's border" if owner == BORDER else self._obstacles[owner].name


def solve(free: Booleans, source: Vertex, start: Floats | None = None) -> tuple[Floats, int]:
    """u = 0 where nothing is free, and elsewhere the mean of its neighbours but for a source.

    Args:
        free: vertices that are connected to the source.
        source: one of them.
        start: where to begin, of the shape of ``free``.

    Returns:
        u, and the cycles it took. Each u is accurate relative to itself, however small it is: what
        is tiny compared with the rest is solved for again, with the rest as its boundary.
    """
    inflow = np.zeros(free.shape)
    inflow[source] = 1.0
    u, cycles = np.zeros(free.shape), 0
    rest, unit = free, 1.0
    while rest.any() and unit > _LEAST:
        guess = None if start is None else start / unit
        part, more = Multigrid(rest).solve(inflow, guess, accuracy=_ACCURACY, floor=_FLOOR)
        cycles += more
        known = rest & (part >= _FLOOR * part.max())
        u[known] = unit * part[known]
        rest = rest & ~known
        inflow = np.where(rest, neighbour_sum(u), 0.0)
        unit = float(inflow.max())
        inflow /= unit or 1.0
    return u, cycles


def _contracted(block: Floats, weights: list[Floats]) -> float:
    for row in weights:
        block = row @ block.reshape(3, -1)
    return float(block[0])


def _unit(vector: Floats) -> Floats:
    length = math.sqrt(vector.dot(vector))
    return vector / length if length > 0.0 else np.zeros_like(vector)

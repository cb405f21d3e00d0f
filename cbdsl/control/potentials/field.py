"""Harmonic function on a grid, and the descent from any point to its goal (Eq 3.2)."""

# Model: a harmonic function has no local minima, so that its gradient leads to the goal from every
# free point that is connected with it (Connolly and Grupen, 1993).
# Equation: Laplace's equation, sum_i d^2 phi / dx_i^2 = 0, on a regular grid. There, phi at each
# free vertex is the mean of its 2 n neighbours, with phi = 0 at the goal and 1 at obstacles. The
# solved function is u, a multiple of 1 - phi. Far from the goal, phi differs from 1 by less than
# the precision of a double, but u keeps its digits, because it is accurate relative to itself.
# Between vertices, u is interpolated by a quadratic B-spline: its weights are positive and add up
# to 1, so that the interpolation has no minima of its own.
# Assumptions: obstacles are constant while a field is in use, and the clearance covers the body
# around the point. A moving goal changes the source alone; a new field starts from the solution of
# the last.
# Source: Section 3.1.3, Eq 3.2; the scaling of u and the spline are additions of this project.

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.control.potentials.grid import BORDER, FREE, Grid, Vertex
from cbdsl.control.potentials.multigrid import Multigrid, neighbour_sum
from cbdsl.control.signal import SignalError
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Booleans, Floats

# Largest residual at a vertex, as a share of 1 - phi there. Next to the flattest saddles of a
# thousand cells, neighbours differ by a hundred times that share.
_ACCURACY = 1e-5
# Below this share of its largest value, 1 - phi is solved for again, with rescaled units.
_FLOOR = 1e-10
# Smallest unit, below which the numbers lose precision.
_LEAST = 1e-280


class NoPathError(SignalError):
    """No free path leads to the goal; the message says why."""


class Slope(NamedTuple):
    """Value and direction of the field at a point.

    Attributes:
        potential: Harmonic potential phi_h, from 0 at the goal to 1 at obstacles.
        closeness: Value of 1 - phi_h, exact even if phi_h rounds to 1.
        direction: Unit vector of steepest descent, shape (n,); 0 at the goal.
        depth: Distance from a point inside an obstacle or the border to the nearest point with a
            path to the goal, in cells; 0 elsewhere.
    """

    potential: float
    closeness: float
    direction: Floats
    depth: float = 0.0


class HarmonicField:
    """Harmonic potential phi_h: 0 at the goal's vertex, 1 on obstacles and the border.

    The stored function u is a multiple of 1 - phi_h: the solution for a source at the goal's vertex
    and 0 at obstacles. A moving goal thus changes only the right side of the equation. The tiny
    differences far from the goal keep all their digits.

    Between vertices, u is a quadratic spline with the vertices' values as coefficients. Its
    gradient is continuous. As a mean of shifted copies of u, it is harmonic like u on every grid
    that is shifted by less than a cell. Within two cells of the goal, if the line of sight is free,
    the field turns into a cone around the goal itself.

    Args:
        grid: Grid of the vertices.
        obstacles: Obstacles in the workspace.
        goal: Goal of the field, shape (n,).
        start: Field of a similar scene on the same grid, as initial solution.

    Attributes:
        u: Values at the vertices, with the grid's shape.
        cycles: Number of multigrid cycles of the solution.

    Raises:
        NoPathError: If the goal is outside the grid, or too close to an obstacle or the border.
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
        # Padding for the spline around any vertex.
        self._padded = np.pad(self.u, 1)
        self._top = self._spline(grid.position(self._source))[0]
        self._shell = 1.0 - self._mean_around(self._source) / self._top

    def suits(self, goal: Floats) -> bool:
        """Return whether the field leads to a goal, shape (n,), as it does to its original goal."""
        vertex = self.grid.position(self._source)
        near = float(np.abs(goal - vertex).max()) <= 0.75 * self.grid.spacing
        return near and self._sees(vertex, goal)

    def slope(self, point: Floats, goal: Floats) -> Slope:
        """Return the potential and the direction of descent.

        Inside an obstacle or the border, the direction leads out.

        Args:
            point: Point, shape (n,).
            goal: Goal that the field ``suits``, shape (n,).

        Raises:
            NoPathError: If no free path leads from the point to the goal.
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
        """Blend a cone around the goal into the harmonic function between one and two cells."""
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
        """Return u and its gradient at a point, the latter in a unit of its own."""
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
        block = block / largest  # squares of tiny values would underflow
        gradient = [
            _contracted(block, [slopes[a] if a == axis else weights[a] for a in range(len(point))])
            for axis in range(len(point))
        ]
        return largest * _contracted(block, list(weights)), np.array(gradient)

    def _block(self, middle: Floats) -> Floats | None:
        """Return u around a vertex, 3 values along each axis, or ``None`` outside the grid."""
        if (middle < 0).any() or (middle >= self.grid.shape).any():
            return None
        return self._padded[tuple(slice(int(i), int(i) + 3) for i in middle)]

    def _mean_around(self, vertex: Vertex) -> float:
        """Return the mean of the spline over the vertex's neighbours."""
        here, steps = self.grid.position(vertex), self.grid.spacing * np.eye(len(vertex))
        return float(np.mean([self._spline(here + s)[0] for s in (*steps, *-steps)]))

    def _sees(self, point: Floats, goal: Floats) -> bool:
        """Return whether the segment between near points stays in cells that lead to the goal."""
        shares = np.linspace(0.0, 1.0, 17)[:, None]
        return self.grid.holds(self._reached, point + shares * (goal - point))

    def _way_out(self, point: Floats) -> Floats:
        """Return the vector to the nearest vertex from which a path leads to the goal.

        Vertices are searched in boxes around the point that grow until no vertex outside can be
        nearer. A point is mostly a cell or two inside, while a grid has a hundred thousand cells.
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
        """Return a message with the barriers that separate a free vertex from the goal."""
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
    """Solve for u, the mean of its neighbours on free vertices but for a source, and 0 elsewhere.

    Args:
        free: Vertices that are connected to the source.
        source: Vertex of the source.
        start: Initial solution, with the shape of ``free``.

    Returns:
        u, and the number of cycles. Each u is accurate relative to itself, however small it is.
        Values that are tiny compared with the rest are solved for again, with the rest as boundary.
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

"""Laplace's equation on the free vertices of a grid, at a cost proportional to their number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Booleans, Floats

Values = NDArray[Any]
"""Single or double precision."""

# Two sweeps of weighted Jacobi iteration damp the errors that a coarser grid cannot represent.
_WEIGHTS = (0.6, 1.1)
_COARSEST_WEIGHTS = _WEIGHTS * 4
_CYCLES = 200
# Number of elements of each operand that fit into a core's cache together.
_STRETCH = 1 << 15


class ConvergenceError(ArithmeticError):
    """Failure of the iteration to reach the requested accuracy."""


class Multigrid:
    """Solver of 2 n u_i - sum of the neighbours' u = b_i on free vertices, with u = 0 elsewhere.

    Conjugate gradients, preconditioned by one V-cycle of geometric multigrid [Tatebe 1993]. A
    coarser grid takes every second vertex along each axis, free if it is free in the finer grid.
    Corrections are interpolated linearly. No matrix is assembled, so that new obstacles cost no
    more than a mask. The cycle works in single precision, which halves its memory traffic;
    residuals and sums are double.

    Args:
        free: True for unknown vertices, n-dimensional; the grid's border must not be free.
    """

    def __init__(self, free: Booleans) -> None:
        self._finest = _Level(free, np.float64)
        self._levels = [_Level(free, np.float32)]
        while max(free.shape) > 3 and min(free.shape) >= 3:
            free = _coarser(free)
            if not free.any():
                break
            self._levels.append(_Level(free, np.float32))

    def solve(
        self, source: Floats, start: Floats | None = None, *, accuracy: float, floor: float
    ) -> tuple[Floats, int]:
        """Iterate until each u_i is the mean of its neighbours, up to a relative error.

        Args:
            source: Right side b, with the grid's shape, not negative and not 0 everywhere.
            start: Initial solution; one for a similar source saves cycles.
            accuracy: Largest residual at a vertex, as a share of u there.
            floor: Share of the largest u below which residuals are compared with that share
                instead.

        Returns:
            u, with the grid's shape, and the number of cycles.

        Raises:
            ConvergenceError: If more than 200 cycles are needed.
        """
        finest, shape = self._finest, source.shape
        u = np.zeros(source.size) if start is None else start.ravel() * finest.mask
        residual = finest.residual(u, source.ravel()).copy()
        # Arrays are reused, because fresh memory costs more than the arithmetic.
        direction, before, part = np.zeros_like(u), residual.copy(), np.empty_like(u)
        slope, test = 1.0, _Accuracy(accuracy, floor)
        for cycle in range(_CYCLES):
            if test.holds(u, residual, part):
                return u.reshape(shape), cycle
            z = self._cycle(residual.astype(np.float32), 0).astype(np.float64)
            # Rounding makes the cycle differ slightly each time; the flexible variant tolerates it.
            direction *= (_dot(z, residual) - _dot(z, before)) / slope
            direction += z
            slope = _dot(z, residual)
            image = finest.residual(direction)
            step = -slope / _dot(direction, image)
            u += np.multiply(direction, step, out=part)
            before[:] = residual
            residual += np.multiply(image, step, out=part)
        raise ConvergenceError(f"no convergence in {_CYCLES} cycles")

    def _cycle(self, b: Values, depth: int) -> Values:
        """Return one V-cycle from 0; symmetric, as conjugate gradients require."""
        level = self._levels[depth]
        if depth + 1 == len(self._levels):
            return level.relax(None, b, _COARSEST_WEIGHTS)
        u = level.relax(None, b, _WEIGHTS)
        below = self._levels[depth + 1]
        coarse = _restricted(level.residual(u, b).reshape(level.shape))
        # The coarse grid's spacing is twice as large, and its square appears in the equation.
        coarse *= 4.0
        correction = self._cycle(coarse.ravel(), depth + 1).reshape(below.shape)
        u += _prolonged(correction, level.shape).ravel() * level.mask
        return level.relax(u, b, _WEIGHTS[::-1])


class _Level:
    """Grid level with the equation's residual and relaxation."""

    def __init__(self, free: Booleans, kind: type[np.floating[Any]]) -> None:
        self.shape = free.shape
        self.mask = free.ravel().astype(kind)
        self._strides = [int(np.prod(free.shape[a + 1 :], dtype=int)) for a in range(free.ndim)]
        self._diagonal = kind(2 * free.ndim)
        self._residual = np.zeros(free.size, kind)

    def residual(self, u: Values, b: Values | None = None) -> Values:
        """Return b + sum of neighbours - 2 n u on free vertices, 0 elsewhere.

        The next call overwrites the array.
        """
        residual = self._residual
        border = self._strides[0]
        # Beyond the border, neighbours belong to other rows, but there the mask is 0.
        for start in range(border, u.size - border, _STRETCH):
            stop = min(start + _STRETCH, u.size - border)
            part = residual[start:stop]
            np.multiply(u[start:stop], -self._diagonal, out=part)
            for stride in self._strides:
                part += u[start - stride : stop - stride]
                part += u[start + stride : stop + stride]
            if b is not None:
                part += b[start:stop]
            part *= self.mask[start:stop]
        return residual

    def relax(self, u: Values | None, b: Values, weights: Sequence[float]) -> Values:
        """Return u after sweeps of weighted Jacobi iteration, from 0 without ``u``."""
        for weight in weights:
            change = b * self.mask if u is None else self.residual(u, b)
            change *= weight / self._diagonal
            if u is None:
                u = change
            else:
                u += change
        assert u is not None
        return u


def neighbour_sum(u: Floats) -> Floats:
    """Return the sum of each vertex's neighbours, for vertices inside the border."""
    flat = u.ravel()
    around = _Level(np.ones(u.shape, bool), np.float64).residual(flat, 2.0 * u.ndim * flat)
    return around.reshape(u.shape)


def _dot(a: Values, b: Values) -> float:
    # Unlike a matrix product, this starts no threads, which cost more than they save here.
    return float(np.einsum("i,i->", a, b))


class _Accuracy:
    """Test of a solution at all vertices; the vertex that failed last is tested first.

    Args:
        accuracy, floor: As for ``Multigrid.solve``.
    """

    def __init__(self, accuracy: float, floor: float) -> None:
        self._accuracy, self._floor = accuracy, floor
        self._failed = 0

    def holds(self, u: Floats, residual: Floats, part: Floats) -> bool:
        """Return whether u is accurate.

        Args:
            u: Solution, shape (n,).
            residual: Residual of the solution, shape (n,).
            part: Array that is overwritten, shape (n,).
        """
        largest = float(u.max())
        if largest <= 0.0:
            return False
        least, at = self._floor * largest, self._failed
        if abs(residual[at]) > self._accuracy * max(u[at], least):
            return False
        bounds = np.maximum(u, least, out=part)
        bounds *= self._accuracy
        excess = np.subtract(np.abs(residual), bounds, out=part)
        self._failed = int(excess.argmax())
        return bool(excess[self._failed] <= 0.0)


def _coarser(free: Booleans) -> Booleans:
    """Return every second vertex along each axis, with a border for odd and even numbers."""
    for axis in range(free.ndim):
        rows = np.moveaxis(free, axis, 0)
        half = np.zeros((rows.shape[0] // 2 + 1, *rows.shape[1:]), bool)
        inner = rows[2:-1:2]
        half[1 : 1 + len(inner)] = inner
        free = np.moveaxis(half, 0, axis)
    return np.ascontiguousarray(free)


def _restricted(fine: Values) -> Values:
    """Return weighted means (1/4, 1/2, 1/4 along each axis) around every second vertex."""
    for axis in range(fine.ndim):
        rows = np.moveaxis(fine, axis, 0)
        half = np.zeros((rows.shape[0] // 2 + 1, *rows.shape[1:]), fine.dtype)
        odd = 0.25 * rows[1::2]
        even = rows[::2]
        half[: len(even)] = even
        half *= 0.5
        half[: len(odd)] += odd
        half[1 : 1 + len(odd)] += odd[: len(half) - 1]
        fine = np.moveaxis(half, 0, axis)
    return np.ascontiguousarray(fine)


def _prolonged(coarse: Values, shape: tuple[int, ...]) -> Values:
    """Return linear interpolation along each axis, cut to ``shape``."""
    for axis, count in enumerate(shape):
        rows = np.moveaxis(coarse, axis, 0)
        fine = np.empty((2 * len(rows) - 1, *rows.shape[1:]), coarse.dtype)
        fine[::2] = rows
        np.add(rows[:-1], rows[1:], out=fine[1::2])
        fine[1::2] *= 0.5
        coarse = np.moveaxis(fine[:count], 0, axis)
    return np.ascontiguousarray(coarse)

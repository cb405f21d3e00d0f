"""Arithmetic of small vectors in loops; array expressions compile and run more slowly."""

from __future__ import annotations

import math

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled, compiled_sum


@compiled
def fill(row: Floats, value: float) -> None:
    """Set all components to a value."""
    for i in range(len(row)):
        row[i] = value


@compiled
def copy(row: Floats, source: Floats, factor: float) -> None:
    """Set a vector to a multiple of another."""
    for i in range(len(row)):
        row[i] = factor * source[i]


@compiled
def add(row: Floats, other: Floats, factor: float) -> None:
    """Add a multiple of another vector."""
    for i in range(len(row)):
        row[i] += factor * other[i]


@compiled
def scale(row: Floats, factor: float) -> None:
    """Multiply a vector by a factor."""
    for i in range(len(row)):
        row[i] *= factor


@compiled
def norm(row: Floats) -> float:
    """Return the Euclidean length of a vector."""
    return math.sqrt(dot(row, row))


@compiled_sum
def dot(first: Floats, second: Floats) -> float:
    """Return the scalar product of two vectors."""
    total = 0.0
    for i in range(len(first)):
        total += first[i] * second[i]
    return total


@compiled
def cross(left: Floats, right: Floats, product: Floats) -> None:
    """Write the cross product of two vectors (3,)."""
    product[0] = left[1] * right[2] - left[2] * right[1]
    product[1] = left[2] * right[0] - left[0] * right[2]
    product[2] = left[0] * right[1] - left[1] * right[0]

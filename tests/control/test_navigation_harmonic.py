"""The harmonic potential meets the conditions of a navigation function that it claims, no others.

It is solved on a grid, so that the tests check only properties that a grid can show.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.control.potentials.field import HarmonicField
from cbdsl.control.potentials.grid import Grid
from cbdsl.control.potentials.harmonic import Harmonic
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats
from cbdsl.types.potential import POTENTIALS, Condition
from tests.control.potentials.test_harmonic import prepared

LOWER, UPPER = -np.ones(2), np.ones(2)
GOAL = np.array([-0.5, 0.0])
OBSTACLES = (
    Obstacle.sphere("ball", np.array([0.1, 0.1]), 0.3),
    Obstacle("box", np.array([-0.4, 0.4]), np.array([-0.1, 0.8])),
)


def field(spacing: float, *obstacles: Obstacle) -> HarmonicField:
    return HarmonicField(Grid.between(LOWER, UPPER, spacing), obstacles, GOAL)


def free(rng: np.random.Generator, distance: float) -> Floats:
    """Return a random point at more than a distance from all obstacles and the goal."""
    while True:
        point = rng.uniform(LOWER + distance, UPPER - distance)
        clear = all(obstacle.distance(point) > distance for obstacle in OBSTACLES)
        if clear and np.linalg.norm(point - GOAL) > distance:
            return point


def analytic(rng: np.random.Generator) -> None:
    """Check that its value is the mean over any circle around, as for harmonic functions alone."""
    solved = field(0.02, *OBSTACLES)
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    circle = 0.12 * np.column_stack((np.cos(angles), np.sin(angles)))
    for _ in range(20):
        centre = free(rng, 0.16)
        around = np.mean([solved.slope(centre + by, GOAL).closeness for by in circle])
        assert around == pytest.approx(solved.slope(centre, GOAL).closeness, rel=0.01)


def polar(rng: np.random.Generator) -> None:
    """Check that every descent ends at the goal."""
    potential = Harmonic(LOWER, UPPER, spacing=0.05, scale=0.05).potential
    for _ in range(8):
        point = free(rng, 0.1)
        for _ in range(300):
            point = point + prepared(potential, point, GOAL, OBSTACLES).step
        np.testing.assert_allclose(point, GOAL, atol=1e-3)


def not_admissible(rng: np.random.Generator) -> None:
    """Steepen towards the goal without bound, as far as the grid resolves it."""
    steepness = [
        solved.slope(GOAL + np.array([spacing, 0.0]), GOAL).potential / spacing
        for spacing in (0.1, 0.05, 0.025)
        for solved in (field(spacing, *OBSTACLES),)
    ]
    assert steepness[1] > 1.5 * steepness[0]
    assert steepness[2] > 1.5 * steepness[1]


def not_morse(rng: np.random.Generator) -> None:
    """Merge two saddles at a gap of just the width at which its lee disappears.

    Through a narrow gap less comes than around, so that phi has two saddles on the axis of
    symmetry behind it; through a wide gap it falls all along. At the width between, both are one
    point, where by symmetry and Laplace's equation all second derivatives vanish.
    """
    assert saddles_behind(gap=0.2) == 2
    assert saddles_behind(gap=0.3) == 0


def saddles_behind(gap: float) -> int:
    """Count saddles on the axis through the goal and the middle of a gap between two boxes."""
    boxes = [
        Obstacle(f"box {side}", np.array([0.0, low]), np.array([0.1, high]))
        for side, low, high in (("left", gap / 2, 0.2), ("right", -0.2, -gap / 2))
    ]
    u = field(0.025, *boxes).u
    along = u[:, u.shape[1] // 2]
    rises = np.sign(np.diff(along[np.argmax(along) :]))
    return int(np.count_nonzero(np.diff(rises)))


EVIDENCE: dict[str, tuple[bool, Callable[[np.random.Generator], None]]] = {
    "analytic": (True, analytic),
    "polar": (True, polar),
    "admissible": (False, not_admissible),
    "morse": (False, not_morse),
}


@pytest.mark.parametrize("condition", EVIDENCE)
def test_claimed_conditions_of_the_harmonic_function_are_those_that_hold(
    condition: str, rng: np.random.Generator
) -> None:
    holds, evidence = EVIDENCE[condition]
    claim = getattr(POTENTIALS["harmonic"].navigation, condition)
    assert (claim is Condition.MET) == holds
    evidence(rng)


def test_displacements_are_bounded_where_the_gradient_is_not(rng: np.random.Generator) -> None:
    """Displacements are bounded because the gradient gives only their direction (Eq 7.1)."""
    potential = Harmonic(LOWER, UPPER, spacing=0.05, scale=0.05).potential
    for _ in range(50):
        found = prepared(potential, free(rng, 0.02), GOAL, OBSTACLES)
        assert np.linalg.norm(found.residual) <= 0.05 + 1e-12

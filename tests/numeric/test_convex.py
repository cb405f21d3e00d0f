"""Distances between convex bodies."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.numeric.convex import Convex, gap

UNTURNED = np.eye(3)


def _ball(radius: float, *position: float) -> Convex:
    return Convex("ball", (radius, radius, radius), np.array(position), UNTURNED)


def _turned(rng: np.random.Generator) -> np.ndarray:
    turned, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    return turned * np.sign(np.linalg.det(turned))


def test_balls_are_as_far_apart_as_their_centres_less_their_radii() -> None:
    assert gap(_ball(0.1, 0, 0, 0), _ball(0.05, 0.3, 0.4, 0)) == pytest.approx(0.35)
    assert gap(_ball(0.1, 0, 0, 0), _ball(0.05, 0.1, 0, 0)) == 0.0


@pytest.mark.parametrize("height", [0.07, 0.0701, 0.1])
@pytest.mark.parametrize("kind", ["ball", "box", "cylinder"])
def test_distance_to_a_table_below_is_the_height(kind: str, height: float) -> None:
    table = Convex("box", (1.0, 1.0, 0.02), np.zeros(3), UNTURNED)
    thing = Convex(kind, (0.05, 0.05, 0.05), np.array([0.3, 0.1, height]), UNTURNED)  # type: ignore[arg-type]
    assert gap(table, thing) == pytest.approx(height - 0.07, abs=1e-6)


@pytest.mark.parametrize("seed", range(40))
def test_gap_is_that_of_the_nearest_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = rng.choice(["ball", "box", "cylinder"], 2)
    one, other = (
        Convex(
            kind,
            (a, a if kind != "box" else b, a if kind == "ball" else c),
            rng.uniform(-0.3, 0.3, 3),
            _turned(rng),
        )
        for kind, (a, b, c) in zip(kinds, rng.uniform(0.02, 0.2, (2, 3)), strict=True)
    )
    distance = gap(one, other)
    # Along every direction the bodies' projections are at most that far apart, and along the best
    # one nearly as far.
    directions = rng.standard_normal((4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    apart = max(float(d @ other.support(-d) - d @ one.support(d)) for d in directions)
    assert apart <= distance + 1e-6
    assert distance == 0.0 or apart >= distance - 0.02
    assert gap(other, one) == pytest.approx(distance, abs=1e-6)

"""The range potential against the formula of its source."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.potentials.range import between
from tests.control.evaluation import Signal, evaluate


def test_range_potential_equals_the_sum_of_cosines(rng: np.random.Generator) -> None:
    lower, upper = -rng.uniform(0.5, 3, 7), rng.uniform(0.5, 3, 7)
    for q in rng.uniform(lower, upper, (50, 7)):
        angles = np.pi * (q - (lower + upper) / 2) / (upper - lower)
        phi = evaluate(between(lower, upper), Signal(q, np.eye(7))).phi
        assert phi == pytest.approx(7 - np.cos(angles).sum(), abs=1e-14)


def test_range_potential_keeps_full_rank_at_the_centre() -> None:
    lower, upper = -np.ones(5), np.full(5, 2.0)
    evaluation = evaluate(between(lower, upper), Signal(np.full(5, 0.5), np.eye(5)))
    assert evaluation.phi == 0.0
    assert np.linalg.matrix_rank(evaluation.jacobian) == 5


@pytest.mark.parametrize("upper", [(np.inf, np.inf), (1.0, -1.0), (1.0, np.nan)])
def test_range_potential_of_joints_without_limits_is_refused(upper: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="finite joint limits"):
        between(np.array([-1.0, -np.inf if np.isinf(upper[1]) else -1.0]), np.array(upper))


def test_joint_without_end_keeps_away_from_nothing() -> None:
    both = between(np.array([-1.0, -np.inf]), np.array([2.0, np.inf]))
    alone = between(np.array([-1.0]), np.array([2.0]))
    expected = evaluate(alone, Signal(np.array([1.5]), np.eye(1)))
    for angle in (-5.0, 0.3, 40.0):
        found = evaluate(both, Signal(np.array([1.5, angle]), np.eye(2)))
        assert found.phi == expected.phi and not found.jacobian[:, 1].any()

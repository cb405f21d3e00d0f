"""Springs on types whose difference is not a subtraction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.potentials.spring import along_axes, circular, spring
from cbdsl.kinematics.rotation import exp
from tests.control.evaluation import Signal, evaluate

EYE = np.eye(3)


def test_spring_of_joints_with_limits_keeps_whole_turns() -> None:
    signal = Signal(np.array([-3.0]), np.eye(1))
    evaluation = evaluate(spring("configuration", 1), signal, np.array([3.0]))
    np.testing.assert_allclose(evaluation.residual, [6.0])
    assert evaluation.phi == pytest.approx(18.0)


@given(st.floats(-100, 100), st.floats(-100, 100), st.integers(-9, 9))
def test_circular_spring_of_any_positions_takes_the_short_way(
    value: float, reference: float, turns: int
) -> None:
    law = circular(np.array([True, False]))
    signal = Signal(np.array([value, value]), np.eye(2))
    short, long = evaluate(law, signal, np.array([reference, reference])).residual
    assert abs(short) <= np.pi + 1e-12
    assert np.cos(value + short) == pytest.approx(np.cos(reference), abs=1e-9)
    assert np.sin(value + short) == pytest.approx(np.sin(reference), abs=1e-9)
    assert long == reference - value
    turned = np.array([reference + 2 * np.pi * turns, reference])
    again = evaluate(law, signal, turned).residual[0]
    assert np.cos(again) == pytest.approx(np.cos(short), abs=1e-9)


def test_orientation_error_is_in_the_world_frame() -> None:
    rotation, turn = exp(np.array([0.4, 0.2, -0.9])), np.array([0.1, -0.3, 0.2])
    evaluation = evaluate(spring("orientation", 3), Signal(rotation, EYE), exp(turn) @ rotation)
    np.testing.assert_allclose(evaluation.residual, turn, atol=1e-15)


@pytest.mark.parametrize("axis", range(3))
def test_free_axis_may_turn(axis: int) -> None:
    free = spring("orientation", 3, "xyz"[axis])
    signal = Signal(exp(np.array([0.4, 0.2, -0.9])), EYE)
    spun = signal.value @ exp(1.3 * EYE[axis])
    assert evaluate(free, signal, spun).phi < 1e-30


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("off", [0.0, 1e-14, 1e-9, 1e-3])
def test_opposite_axis_is_turned_round(axis: int, off: float) -> None:
    free = spring("orientation", 3, "xyz"[axis])
    rotation = exp(np.array([0.4, 0.2, -0.9]))
    wanted = rotation @ exp((np.pi - off) * EYE[(axis + 2) % 3])
    evaluation = evaluate(free, Signal(rotation, EYE), wanted)
    assert np.linalg.norm(evaluation.residual) == pytest.approx(np.pi - off, abs=1e-7)
    turned = exp(evaluation.jacobian.T @ evaluation.residual) @ rotation
    np.testing.assert_allclose(turned[:, axis], wanted[:, axis], atol=1e-12)


@pytest.mark.parametrize("axes", [(0,), (2,), (0, 1), (0, 2)])
@pytest.mark.parametrize("factors", [1, 2])
def test_axes_that_are_not_compared_are_free(axes: tuple[int, ...], factors: int) -> None:
    rng = np.random.default_rng(2)
    value, reference = rng.normal(size=3 * factors), rng.normal(size=3 * factors)
    jacobian = rng.normal(size=(3 * factors, 5))
    spring_ = along_axes(axes, factors)
    evaluation = evaluate(spring_, Signal(value, jacobian), reference)
    chosen = [3 * factor + axis for factor in range(factors) for axis in axes]
    np.testing.assert_array_equal(evaluation.residual, (reference - value)[chosen])
    np.testing.assert_array_equal(evaluation.jacobian, jacobian[chosen])
    others = [place for place in range(3 * factors) if place not in chosen]
    value[others] += 1.0
    assert evaluate(spring_, Signal(value, jacobian), reference).phi == evaluation.phi

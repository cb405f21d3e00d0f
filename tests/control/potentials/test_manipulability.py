"""Manipulability at singularities and of several arms, and the law as printed against ours."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.potentials.manipulability import of_jacobian
from cbdsl.numeric.arrays import Floats
from tests.control.chain import Chain
from tests.control.evaluation import Evaluation, evaluate
from tests.control.test_potential_registry import curved, manipulator


def planar(chain: Chain, q: Floats) -> Evaluation:
    """Evaluate the tip's position in the plane in which the chain moves."""
    jacobian, curvature = curved(chain, q)
    return of(jacobian[:2], curvature[:2])


def of(jacobian: Floats, curvature: Floats) -> Evaluation:
    return evaluate(of_jacobian(*jacobian.shape), manipulator(jacobian, curvature))


def orthonormal(rows: int, columns: int, rng: np.random.Generator) -> Floats:
    """Return rows at right angles to each other."""
    return np.linalg.qr(rng.normal(size=(columns, rows)))[0].T


def test_manipulability_equals_eq_3_5(rng: np.random.Generator) -> None:
    for rows, joints in ((2, 3), (3, 3), (3, 7), (6, 6), (6, 14)):
        jacobian = rng.normal(size=(rows, joints))
        phi = of(jacobian, np.zeros((rows, joints, joints))).phi
        assert phi == pytest.approx(-np.sqrt(np.linalg.det(jacobian @ jacobian.T)), rel=1e-9)


@pytest.mark.parametrize("elbow", [1.2, -0.4, 3.0])
def test_two_links_are_most_manipulable_at_a_right_angle(elbow: float) -> None:
    evaluation = planar(Chain.planar(2), np.array([0.3, elbow]))
    assert evaluation.phi == pytest.approx(-0.25 * abs(np.sin(elbow)))
    slope = -0.25 * np.cos(elbow) * np.sign(elbow)
    np.testing.assert_allclose(evaluation.jacobian, [[0.0, slope]], atol=1e-9)


def test_shortest_displacement_is_the_negative_gradient(rng: np.random.Generator) -> None:
    here = of(rng.normal(size=(3, 7)), rng.normal(size=(3, 7, 7)))
    displacement = np.linalg.pinv(here.jacobian) @ here.step
    np.testing.assert_allclose(displacement, -here.jacobian[0])


@pytest.mark.parametrize("rows", [2, 3, 6])
@pytest.mark.parametrize("least", [1.0, 1e-2, 1e-4, 1e-6, 1e-9, 1e-15])
def test_gradient_stays_exact_and_bounded_towards_singularities(
    rows: int, least: float, rng: np.random.Generator
) -> None:
    left, right = orthonormal(rows, rows, rng), orthonormal(rows, 8, rng)
    values = np.append(np.linspace(2.0, 1.0, rows - 1), least)
    curvature = rng.normal(size=(rows, 8, 8))
    evaluation = of((left * values) @ right, curvature)
    others = np.array([np.prod(np.delete(values, i)) for i in range(rows)])
    gradient = -np.einsum("kr,r,ri,kij->j", left, others, right, curvature)
    assert evaluation.phi == pytest.approx(-np.prod(values), rel=1e-7, abs=1e-14)
    if least > 1e-12:  # nearer, the vanishing direction is known no more than its sign
        np.testing.assert_allclose(evaluation.jacobian[0], gradient, rtol=1e-5, atol=1e-5)
    assert np.abs(evaluation.jacobian).max() <= 2 * others.max() * rows * 8


@pytest.mark.parametrize("elbow", [0.0, 1e-12, -1e-12, np.pi])
def test_descent_leaves_a_singularity(elbow: float) -> None:
    chain, q = Chain.planar(2), np.array([0.3, elbow])
    evaluation = planar(chain, q)
    (gradient,) = evaluation.jacobian
    assert np.linalg.norm(gradient) == pytest.approx(0.25)
    assert planar(chain, q - 0.1 * gradient).phi < evaluation.phi - 0.001


def test_twice_singular_is_flat_not_undefined() -> None:
    evaluation = of(np.zeros((3, 5)), np.ones((3, 5, 5)))
    assert evaluation.phi == 0.0
    np.testing.assert_array_equal(evaluation.jacobian, np.zeros((1, 5)))
    np.testing.assert_array_equal(evaluation.step, [0.0])


def test_two_arms_have_the_product(rng: np.random.Generator) -> None:
    jacobians, curvatures = rng.normal(size=(2, 3, 7)), rng.normal(size=(2, 3, 7, 7))
    one, two = (of(*arm) for arm in zip(jacobians, curvatures, strict=True))
    stacked, bent = np.zeros((6, 14)), np.zeros((6, 14, 14))
    stacked[:3, :7], stacked[3:, 7:] = jacobians
    bent[:3, :7, :7], bent[3:, 7:, 7:] = curvatures
    both = of(stacked, bent)
    assert both.phi == pytest.approx(-one.phi * two.phi)
    rows = np.hstack((-two.phi * one.jacobian, -one.phi * two.jacobian))
    np.testing.assert_allclose(both.jacobian, rows, rtol=1e-9)


def test_manipulability_ignores_joints_of_other_effectors(rng: np.random.Generator) -> None:
    jacobian, curvature = rng.normal(size=(3, 6)), rng.normal(size=(3, 6, 6))
    own = of(jacobian, curvature)
    wide, bent = np.zeros((3, 10)), np.zeros((3, 10, 10))
    wide[:, 2:8], bent[:, 2:8, 2:8] = jacobian, curvature
    padded = of(wide, bent)
    # Sums of more terms are added up in another order.
    assert padded.phi == pytest.approx(own.phi, rel=1e-14)
    np.testing.assert_allclose(padded.jacobian[:, 2:8], own.jacobian, rtol=1e-12)
    assert not padded.jacobian[:, [0, 1, 8, 9]].any()


def test_printed_law_reaches_singularities_and_ours_leaves_them(rng: np.random.Generator) -> None:
    """Eq 3.18 is Newton's search for phi = 0, and there the arm is singular."""
    chain, best = Chain.planar(3), -0.29273704
    for start in rng.uniform([0.0, 0.3, 0.3], [0.0, 1.5, 1.5], (5, 3)):
        printed = ours = start
        for _ in range(40):
            here = planar(chain, printed)
            printed = printed - np.linalg.pinv(here.jacobian)[:, 0] * here.phi
        for _ in range(100):
            here = planar(chain, ours)
            ours = ours + np.linalg.pinv(here.jacobian) @ here.step
        before = planar(chain, start).phi
        assert planar(chain, printed).phi > 0.25 * before
        assert planar(chain, ours).phi == pytest.approx(best, abs=1e-6)


def test_fewer_joints_than_components_are_refused() -> None:
    with pytest.raises(ValueError, match="2 joints cannot all move 6 components"):
        of_jacobian(6, 2)


@pytest.mark.parametrize("least", [0.0, 1e-12, 1e-6, 1e-3])
@pytest.mark.parametrize("vanishing", [1, 2, 3])
def test_stretched_chain_leaves_a_posture_where_several_values_vanish(
    least: float, vanishing: int, rng: np.random.Generator
) -> None:
    left, right = orthonormal(4, 4, rng), orthonormal(4, 7, rng)
    values = np.append(np.linspace(2.0, 1.0, 4 - vanishing), np.full(vanishing, least))
    start, curvature = (left * values) @ right, rng.normal(size=(4, 7, 7))
    here = of(start, curvature)
    along = -here.jacobian[0] / np.linalg.norm(here.jacobian[0])
    nearby = of(start + 0.01 * curvature @ along, curvature)
    assert np.linalg.norm(here.jacobian) > 1e-4 and nearby.phi < here.phi

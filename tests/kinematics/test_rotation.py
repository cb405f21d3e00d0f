"""Rotation vectors: inverse of the exponential at every angle, and the shortest alignment."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.kinematics.rotation import align, exp, log
from cbdsl.numeric.arrays import Floats

ANGLES = (0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1.0, 2.0, 3.0, 3.14, np.pi - 1e-5, np.pi - 1e-9)


def unit(rng: np.random.Generator) -> Floats:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


@pytest.mark.parametrize("angle", ANGLES)
def test_log_inverts_exp(angle: float, rng: np.random.Generator) -> None:
    for axis in [*np.eye(3), *-np.eye(3), *(unit(rng) for _ in range(50))]:
        np.testing.assert_allclose(log(exp(angle * axis)), angle * axis, rtol=1e-14, atol=2e-15)


def test_half_turn_is_found_up_to_its_sense(rng: np.random.Generator) -> None:
    for axis in [*np.eye(3), *(unit(rng) for _ in range(50))]:
        vector = log(2 * np.outer(axis, axis) - np.eye(3))
        assert np.linalg.norm(vector) == pytest.approx(np.pi, abs=1e-14)
        assert np.linalg.norm(np.cross(vector, axis)) < 1e-14


@given(st.integers(0, 2**32 - 1))
def test_log_never_exceeds_a_half_turn_and_reproduces_the_matrix(seed: int) -> None:
    rotation = exp(np.random.default_rng(seed).uniform(-6, 6, 3))
    vector = log(rotation)
    assert np.linalg.norm(vector) <= np.pi + 1e-14
    np.testing.assert_allclose(exp(vector), rotation, atol=1e-14)


@pytest.mark.parametrize("angle", ANGLES)
def test_align_turns_one_axis_onto_the_other(angle: float, rng: np.random.Generator) -> None:
    for _ in range(20):
        axis = unit(rng)
        normal = np.cross(axis, unit(rng))
        normal /= np.linalg.norm(normal)
        wanted = exp(angle * normal) @ axis
        turn = align(axis, wanted, fallback=normal)
        assert abs(turn @ axis) < 1e-14
        assert np.linalg.norm(turn) == pytest.approx(angle, abs=1e-14)
        np.testing.assert_allclose(exp(turn) @ axis, wanted, atol=1e-14)


def test_align_of_opposite_axes_turns_about_the_fallback() -> None:
    x, _, z = np.eye(3)
    np.testing.assert_allclose(align(z, -z, fallback=x), np.pi * x)
    np.testing.assert_allclose(align(z, z, fallback=x), np.zeros(3))


def test_exp_gives_rotations_about_the_vector(rng: np.random.Generator) -> None:
    for vector in rng.uniform(-4, 4, (50, 3)):
        rotation = exp(vector)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(rotation @ vector, vector, atol=1e-14)
        assert np.trace(rotation) == pytest.approx(1 + 2 * np.cos(np.linalg.norm(vector)))
    np.testing.assert_array_equal(exp(np.zeros(3)), np.eye(3))

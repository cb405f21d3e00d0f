"""Rotations: the algebra that every frame relies on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.kinematics.pose import Pose
from cbdsl.kinematics.quaternion import rotations

component = st.floats(-1, 1)
quaternions = (
    st.tuples(component, component, component, component)
    .filter(lambda q: sum(c * c for c in q) > 1e-2)
    .map(lambda q: np.array(q) / np.linalg.norm(q))
)


@given(quaternions)
def test_rotation_matrices_are_orthonormal(quaternion: np.ndarray) -> None:
    rotation = rotations(quaternion)
    assert rotation @ rotation.T == pytest.approx(np.eye(3))
    assert np.linalg.det(rotation) == pytest.approx(1)


@given(quaternions, quaternions)
def test_rotations_of_several_vectors_equal_single_ones(one: np.ndarray, other: np.ndarray) -> None:
    assert np.array_equal(rotations(np.stack((one, other))), [rotations(one), rotations(other)])


@given(quaternions)
def test_quaternion_comes_back_up_to_its_sign(quaternion: np.ndarray) -> None:
    again = Pose.of((0, 0, 0), tuple(quaternion)).quaternion()
    assert abs(np.dot(again, quaternion)) == pytest.approx(1)


@given(quaternions, st.floats(-3, 3))
def test_turn_keeps_its_axis_and_has_its_angle(quaternion: np.ndarray, angle: float) -> None:
    axis = rotations(quaternion)[:, 0]
    rotation = Pose.turned(axis, angle).rotation
    assert rotation @ axis == pytest.approx(axis)
    assert np.trace(rotation) == pytest.approx(1 + 2 * np.cos(angle))


def test_frames_compose_from_the_outside_in() -> None:
    quarter = Pose(np.array([1.0, 0, 0]), Pose.turned(np.array([0.0, 0, 1]), np.pi / 2).rotation)
    assert (quarter @ quarter).position == pytest.approx([1, 1, 0])

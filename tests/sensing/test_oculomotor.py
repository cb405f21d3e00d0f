"""Headings, positions and their Jacobians agree at every visible point (Eq 3.14)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from cbdsl.control.potentials.localizability import seen_by
from cbdsl.kinematics.kinematics import Frame
from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.association.stereo import Ray, triangulate
from cbdsl.sensing.vision.regions.camera import (
    direction,
    heading,
    heading_jacobian,
    sighting_jacobian,
)
from tests.control.evaluation import Signal, evaluate

Cameras = tuple[Frame, Frame]

POINTS = 100
STEP = 1e-6


@pytest.fixture(params=range(3))
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    return np.random.default_rng(request.param)


def slopes(function: Callable[[Floats], Floats], at: Floats) -> Floats:
    """Return central differences, shape (m, n)."""
    columns = [(function(at + d) - function(at - d)) / (2 * STEP) for d in STEP * np.eye(len(at))]
    return np.column_stack(columns)


def cameras(rng: np.random.Generator) -> Cameras:
    """Return two cameras a third of a metre apart, each turned a few degrees about any axis."""
    left, right = (
        Frame(np.array([0.0, side, 0.0]) + rng.normal(size=3) * 0.02, exp(rng.normal(size=3) * 0.1))
        for side in (0.15, -0.15)
    )
    return left, right


def point(rng: np.random.Generator) -> Floats:
    return rng.uniform([0.3, -0.4, -0.4], [1.5, 0.4, 0.4])


def headings(eyes: Cameras, position: Floats) -> Floats:
    """Return azimuth and elevation in both cameras, shape (4,)."""
    return np.concatenate([heading(eye.rotation.T @ (position - eye.position)) for eye in eyes])


def position(eyes: Cameras, angles: Floats) -> Floats:
    """Return the intersection of both lines of sight, shape (3,)."""
    left, right = (
        Ray(eye.position, eye.rotation @ direction(own))
        for eye, own in zip(eyes, angles.reshape(2, 2), strict=True)
    )
    crossing = triangulate(left, right)
    assert crossing is not None
    return crossing.position


def heading_after(at: Floats, turn: Floats) -> Floats:
    """Return the heading of a far point once the camera has turned by a rotation vector."""
    return heading(exp(turn).T @ at)


def sightings(eyes: Cameras, at: Floats) -> Floats:
    """Return the Jacobian of both headings by the position, shape (4, 3)."""
    return np.vstack(
        [sighting_jacobian(eye.rotation.T @ (at - eye.position)) @ eye.rotation.T for eye in eyes]
    )


def phi(eyes: Cameras, at: Floats) -> Floats:
    """Return the localizability of a position, shape (1,)."""
    return np.array([evaluate(seen_by(eyes), Signal(headings(eyes, at), np.eye(4))).phi])


def test_headings_change_with_the_cameras_rotation_as_their_jacobian_says(
    rng: np.random.Generator,
) -> None:
    for angles in rng.uniform(-1.3, 1.3, (POINTS, 2)):
        found = slopes(partial(heading_after, direction(angles)), np.zeros(3))
        np.testing.assert_allclose(heading_jacobian(angles), found, rtol=1e-6, atol=1e-8)


def test_headings_change_with_the_position_as_their_jacobian_says(
    rng: np.random.Generator,
) -> None:
    for _ in range(POINTS):
        eyes, at = cameras(rng), point(rng)
        found = slopes(partial(headings, eyes), at)
        np.testing.assert_allclose(sightings(eyes, at), found, rtol=1e-6, atol=1e-8)


def test_triangulation_inverts_headings(rng: np.random.Generator) -> None:
    for _ in range(POINTS):
        eyes, at = cameras(rng), point(rng)
        np.testing.assert_allclose(position(eyes, headings(eyes, at)), at, atol=1e-12)


def test_oculomotor_jacobian_inverts_that_of_the_headings(rng: np.random.Generator) -> None:
    """Four headings have one position, so that their Jacobian has a left inverse."""
    for _ in range(POINTS):
        eyes, at = cameras(rng), point(rng)
        oculomotor = slopes(partial(position, eyes), headings(eyes, at))
        np.testing.assert_allclose(oculomotor @ sightings(eyes, at), np.eye(3), atol=1e-6)


def test_localizability_changes_with_the_position_as_its_gradient_by_the_headings_says(
    rng: np.random.Generator,
) -> None:
    """Apply the oculomotor Jacobian to the gradient, and the headings' Jacobian back."""
    for _ in range(POINTS):
        eyes, at = cameras(rng), point(rng)
        signal = Signal(headings(eyes, at), sightings(eyes, at))
        gradient = evaluate(seen_by(eyes), signal).jacobian
        found = slopes(partial(phi, eyes), at)
        np.testing.assert_allclose(gradient, found, rtol=1e-5, atol=2e-6)

"""Localizability against its definition and the numbers of Table 3.2."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.control.potentials.localizability import seen_by
from cbdsl.kinematics.kinematics import Frame
from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.regions.camera import heading, sighting_jacobian
from tests.control.evaluation import Evaluation, Signal, evaluate

# phi at 100, 75 and 50 cm; its scale is not given, so that only the two ratios can be compared.
TABLE_3_2 = {1.0: 0.95, 0.75: 0.43, 0.5: 0.14}
RATIOS = np.array([TABLE_3_2[1.0] / TABLE_3_2[0.5], TABLE_3_2[1.0] / TABLE_3_2[0.75]])
Cameras = tuple[Frame, Frame]


def ahead(baseline: float) -> Cameras:
    """Return two cameras that look along x."""
    return tuple(  # type: ignore[return-value]
        Frame(np.array([0.0, side, 0.0]), np.eye(3)) for side in (baseline / 2, -baseline / 2)
    )


def turned(rng: np.random.Generator) -> Cameras:
    """Return two cameras anywhere, each turned by a fraction of a right angle about any axis."""
    return tuple(  # type: ignore[return-value]
        Frame(camera.position + rng.normal(size=3) * 0.02, exp(rng.normal(size=3) * 0.1))
        for camera in ahead(0.35)
    )


def headings(cameras: Cameras, point: Floats) -> Floats:
    return np.concatenate(
        [heading(camera.rotation.T @ (point - camera.position)) for camera in cameras]
    )


def look(cameras: Cameras, angles: Floats) -> Evaluation:
    """Evaluate the potential with the headings themselves for joints."""
    return evaluate(seen_by(cameras), Signal(angles, np.eye(4)))


def points(rng: np.random.Generator, number: int) -> Floats:
    return rng.uniform([0.4, -0.3, -0.3], [1.2, 0.3, 0.3], (number, 3))


def full(cameras: Cameras, point: Floats) -> float:
    """Compute Eq 3.6 with azimuth and elevation of both cameras, J of shape (4, 3)."""
    jacobian = np.vstack([sighting_jacobian(point - camera.position) for camera in cameras])
    return float(1 / np.sqrt(np.linalg.det(jacobian.T @ jacobian)))


def planar(cameras: Cameras, point: Floats) -> float:
    return look(cameras, headings(cameras, point)).phi


def ratios(phi: Callable[[Cameras, Floats], float], baseline: float) -> Floats:
    far, middle, near = (
        phi(ahead(baseline), np.array([depth, 0.0, 0.0])) for depth in (1.0, 0.75, 0.5)
    )
    return np.array([far / near, far / middle])


def test_localizability_equals_its_definition_with_one_angle_per_camera(
    rng: np.random.Generator,
) -> None:
    """Compute J by finite differences, in the plane through the cameras and the point."""
    for point in points(rng, 20):
        cameras = turned(rng)
        along = cameras[1].position - cameras[0].position
        along /= np.linalg.norm(along)
        across = point - cameras[0].position
        across -= across @ along * along
        across /= np.linalg.norm(across)

        def angles(at: Floats) -> Floats:
            sights = [at - camera.position for camera in cameras]  # noqa: B023
            return np.array([np.arctan2(s @ across, s @ along) for s in sights])  # noqa: B023

        small = 1e-6
        jacobian = np.column_stack(
            [
                (angles(point + small * axis) - angles(point - small * axis)) / (2 * small)
                for axis in (along, across)
            ]
        )
        assert planar(cameras, point) == pytest.approx(
            1 / np.sqrt(np.linalg.det(jacobian @ jacobian.T)), rel=1e-6
        )


def test_in_the_plane_of_level_cameras_the_angles_are_the_azimuths() -> None:
    cameras, point = ahead(0.35), np.array([0.7, 0.1, 0.0])
    azimuths = np.vstack([sighting_jacobian(point - camera.position)[0, :2] for camera in cameras])
    assert planar(cameras, point) == pytest.approx(1 / abs(np.linalg.det(azimuths)))


@pytest.mark.parametrize("baseline", [0.34, 0.35, 0.36, 0.37, 0.38])
def test_ratios_of_table_3_2(baseline: float) -> None:
    np.testing.assert_allclose(ratios(planar, baseline), RATIOS, rtol=0.05)


def test_best_baseline_is_between_36_and_37_cm() -> None:
    baselines = np.arange(0.05, 1.5, 0.005)
    errors = [np.abs(ratios(planar, baseline) / RATIOS - 1).max() for baseline in baselines]
    assert 0.36 <= baselines[np.argmin(errors)] <= 0.37
    assert min(errors) < 0.025


def test_elevations_would_miss_table_3_2_at_every_baseline() -> None:
    """They add a factor that grows with distance: 12.9 and 3.0 instead of 6.8 and 2.2."""
    baselines = np.arange(0.05, 1.5, 0.005)
    errors = [np.abs(ratios(full, baseline) / RATIOS - 1).max() for baseline in baselines]
    assert min(errors) > 0.07
    np.testing.assert_allclose(ratios(full, 0.35), [12.9, 3.0], rtol=0.01)


def test_printed_jacobian_would_reward_distance() -> None:
    """Printed is the derivative of the position by the headings, the inverse of ours."""
    cameras = ahead(0.35)
    depths = np.linspace(0.3, 1.5, 20)
    ours = np.array([planar(cameras, np.array([depth, 0.0, 0.0])) for depth in depths])
    assert (np.diff(ours) > 0).all()
    assert (np.diff(1 / ours) < 0).all()


def test_gradient_equals_finite_differences_of_headings_that_do_not_meet(
    rng: np.random.Generator,
) -> None:
    for point in points(rng, 20):
        cameras = turned(rng)
        angles = headings(cameras, point) + rng.normal(size=4) * 0.01
        small = 1e-6
        slopes = [
            (look(cameras, angles + d).phi - look(cameras, angles - d).phi) / (2 * small)
            for d in small * np.eye(4)
        ]
        np.testing.assert_allclose(look(cameras, angles).jacobian[0], slopes, rtol=1e-5, atol=1e-6)


def test_newton_steps_bring_a_thing_nearer(rng: np.random.Generator) -> None:
    cameras = ahead(0.35)
    for point in points(rng, 10):
        distance = np.linalg.norm(point)
        for _ in range(5):
            rows = np.vstack([sighting_jacobian(point - camera.position) for camera in cameras])
            here = evaluate(seen_by(cameras), Signal(headings(cameras, point), rows))
            point = point + 0.1 * np.linalg.pinv(here.jacobian) @ here.step
            assert planar(cameras, point) < here.phi
        assert np.linalg.norm(point) < 0.95 * distance


@pytest.mark.parametrize(
    "angles",
    [
        pytest.param([0.0, 0.0, 0.0, 0.0], id="parallel"),
        pytest.param([0.1, 0.2, 0.1, 0.2], id="parallel aside"),
        pytest.param([0.3, 0.0, -0.3, 0.0], id="diverging"),
        pytest.param([0.0, 0.5, -0.4, -0.5], id="behind one of them"),
        pytest.param([-np.pi / 2, 0.0, 0.3, 0.0], id="at the right camera"),
        pytest.param([-np.pi / 2, 0.0, np.pi / 2, 0.0], id="between the cameras"),
    ],
)
def test_lines_of_sight_without_an_intersection_ahead_are_refused_with_a_reason(
    angles: list[float],
) -> None:
    assert math.isnan(look(ahead(0.35), np.array(angles)).phi)
    refuse = seen_by(ahead(0.35)).refuse
    assert refuse is not None
    assert "lines of sight do not meet" in refuse(np.array(angles), np.zeros(0))


def test_localizability_is_finite_or_undefined(rng: np.random.Generator) -> None:
    cameras, given = ahead(0.35), 0
    for scale in (1e-9, 1e-5, 1e-2, 1.0):
        for angles in scale * rng.uniform(-np.pi, np.pi, (300, 4)):
            evaluation = look(cameras, angles)
            if math.isnan(evaluation.phi):
                continue
            given += 1
            assert np.isfinite(evaluation.phi)
            assert np.isfinite(evaluation.jacobian).all()
    assert given > 100


@pytest.mark.parametrize("cameras", [(), ahead(0.35)[:1], ahead(0.0), ahead(np.nan)])
def test_localizability_of_one_camera_is_refused(cameras: tuple[Frame, ...]) -> None:
    with pytest.raises(ValueError, match="two cameras"):
        seen_by(cameras)

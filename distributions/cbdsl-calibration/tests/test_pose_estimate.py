"""Estimated displacements of cameras against the true ones of synthetic views."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from synthetic import IN_HAND, ShownBall, draw_corrections, frame_of

from cbdsl.documents.model import ModelDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.forward import rotation_of
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.association.stereo import Ray, triangulate
from cbdsl.yaml_text.library import Library
from cbdsl_calibration.estimate import LEAST_VIEWS, CalibrationError, estimate

CAMERAS = ("left", "right")

Showing = Callable[..., ShownBall]


@pytest.fixture(scope="module")
def showing(dexter: RobotDocument, kinematics: Kinematics, library: Library) -> Showing:
    file = library.locate(ModelDocument, "showing_right_arm")
    model = library.read(file, ModelDocument).document

    def show(seed: int, spread: float = 1.0, in_hand: Floats = IN_HAND) -> ShownBall:
        rng = np.random.default_rng(seed)
        return ShownBall(dexter, kinematics, model, rng, spread, in_hand)

    return show


@pytest.mark.parametrize("seed", range(6))
def test_known_errors_are_recovered(
    dexter: RobotDocument,
    kinematics: Kinematics,
    showing: Showing,
    seed: int,
) -> None:
    rng = np.random.default_rng(seed)
    true = draw_corrections(rng, rng.uniform(0, 0.01), rng.uniform(0, 0.05), CAMERAS)
    found = estimate(dexter.cameras, showing(seed).views(true, 60, noise=0.1))
    rays = []
    for name in CAMERAS:
        known = found[name].correction
        assert np.linalg.norm(np.subtract(known.position, true[name].position)) < 0.002
        left = rotation_of(np.array(known.rotation)).T @ rotation_of(np.array(true[name].rotation))
        assert np.arccos(min(1.0, (np.trace(left) - 1) / 2)) < np.deg2rad(0.2)
        model = kinematics.frame(dexter.cameras[name].link)
        eye, taken = frame_of(model, true[name]), frame_of(model, known)
        place = np.array((0.55, -0.25, -0.35))
        seen = taken.rotation @ eye.rotation.T @ (place - eye.position)
        rays.append(Ray(taken.position, seen, float(np.linalg.norm(seen))))
    crossing = triangulate(*rays)
    assert crossing is not None
    assert np.linalg.norm(crossing.position - place) < 0.004, "a metre away, on the table"


def test_estimate_allows_another_place_in_the_hand_after_a_new_grasp(
    dexter: RobotDocument, showing: Showing
) -> None:
    true = draw_corrections(np.random.default_rng(8), 0.003, 0.01, CAMERAS)
    views = showing(8).views(true, 30, noise=0.1)
    elsewhere = IN_HAND + np.array((0.004, -0.004, 0.006))
    anew = showing(9, in_hand=elsewhere).views(true, 30, noise=0.1)

    def error(hold: int) -> float:
        """Return the largest error if the second half is taken to be of a hold, m."""
        found = estimate(dexter.cameras, views + [view._replace(hold=hold) for view in anew])
        return max(
            float(np.linalg.norm(np.subtract(found[name].correction.position, true[name].position)))
            for name in CAMERAS
        )

    assert error(3) < 0.0015
    assert error(0) > 2 * error(3), "as if it had lain still"


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "lasting"), [(0.2, 0.0), (0.1, 0.3)])
def test_stated_deviations_are_those_of_many_estimates(
    dexter: RobotDocument, showing: Showing, noise: float, lasting: float
) -> None:
    errors, stated = [], []
    for seed in range(6):
        true = draw_corrections(np.random.default_rng(seed), 0.002, 0.01, CAMERAS)
        found = estimate(dexter.cameras, showing(seed).views(true, 60, noise, lasting))
        for name in CAMERAS:
            error = np.subtract(found[name].correction.position, true[name].position)
            errors.append(np.linalg.norm(error))
            stated.append(found[name].deviations[0])
    # The largest of three deviations is at most the length of the error, and at least a 1.7th.
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) / np.mean(stated) < 2.0


def test_errors_before_and_after_are_reported(dexter: RobotDocument, showing: Showing) -> None:
    true = draw_corrections(np.random.default_rng(3), 0.002, np.deg2rad(0.5), CAMERAS)
    for each in estimate(dexter.cameras, showing(3).views(true, 40, noise=0.2)).values():
        assert each.error(each.before) > 2 * each.error(each.after)
        assert 0.2 < each.error(each.after) < 0.45


def test_estimate_is_robust_to_outliers(dexter: RobotDocument, showing: Showing) -> None:
    true = draw_corrections(np.random.default_rng(5), 0.002, 0.01, CAMERAS)
    views = showing(5).views(true, 60, noise=0.1)
    spoilt = [
        view._replace(point=view.point + 15) if place % 10 == 0 else view
        for place, view in enumerate(views)
    ]
    clean, robust = (estimate(dexter.cameras, each) for each in (views, spoilt))
    for name in CAMERAS:
        change = np.subtract(clean[name].correction.position, robust[name].correction.position)
        assert np.linalg.norm(change) < 0.0015


def test_too_few_views_are_refused(dexter: RobotDocument, showing: Showing) -> None:
    true = draw_corrections(np.random.default_rng(0), 0.002, 0.01, CAMERAS)
    views = showing(0).views(true, LEAST_VIEWS, noise=0.1)
    del views[-1]
    with pytest.raises(CalibrationError, match=f"camera right in {LEAST_VIEWS - 1}; "):
        estimate(dexter.cameras, views)
    with pytest.raises(CalibrationError, match="camera left in 0, right in 0; "):
        estimate(dexter.cameras, [])


@pytest.mark.parametrize("spread", [0.0, 0.03])
def test_hand_that_hardly_moves_is_refused(
    dexter: RobotDocument, showing: Showing, spread: float
) -> None:
    true = draw_corrections(np.random.default_rng(0), 0.002, 0.01, CAMERAS)
    views = showing(0, spread).views(true, 40, noise=0.1)
    with pytest.raises(CalibrationError, match=r"these views .*: .*; (move|show|turn) it"):
        estimate(dexter.cameras, views)

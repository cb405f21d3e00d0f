"""Densities of one joint, and the expected places of reward that they show."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from cbdsl.documents.context import PlaceSection
from cbdsl.documents.form import BoxForm
from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl_reproduction.chapter_4.internal_models import (
    Expectation,
    Known,
    anywhere,
    marginal,
    prominences,
)
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.series import COARTICULATED
from cbdsl_reproduction.trial_runner import LearnedTrial, shipped_dexter, trial_runner

KERNEL = Kernel(
    form="kernel", samples=((-0.5, 0.1), (0.8, 0.2)), bandwidth=(0.1, 0.05), uniform=0.25
)
GAUSSIAN = Gaussian(form="gaussian", mean=(0.2, 0.0), deviation=(0.15, 0.1), uniform=0.1)
ANGLES = np.linspace(-2.0, 2.0, 401)


@pytest.mark.parametrize("density", [KERNEL, GAUSSIAN], ids=["kernel", "gaussian"])
def test_density_adds_up_to_one(density: Kernel | Gaussian) -> None:
    row = marginal(density, 0, ANGLES)
    assert np.trapezoid(row, ANGLES) == pytest.approx(1, abs=1e-6)
    assert row.min() >= density.uniform / 4


def test_peaks_are_where_samples_are() -> None:
    row = marginal(KERNEL, 0, ANGLES)
    peaks = [
        angle
        for angle, before, here, after in zip(ANGLES[1:], row, row[1:], row[2:], strict=False)
        if before < here > after
    ]
    assert peaks == pytest.approx([-0.5, 0.8], abs=0.011)


def test_gaussian_has_its_deviation_apart_from_the_uniform_part() -> None:
    narrow = GAUSSIAN.model_copy(update={"uniform": 0.0})
    rows = np.array([marginal(narrow, 0, ANGLES), np.full(len(ANGLES), 0.25)])
    found = Expectation("joint", -2.0, 2.0, rows, rows[None]).deviations(rows)
    assert found == pytest.approx([0.15, 4 / np.sqrt(12)], rel=0.01)


def peaks(row: NDArray[np.float64]) -> list[float]:
    """Return the maxima of a density over ANGLES that are at least twice the uniform one, rad."""
    before, here, after = row[:-2], row[1:-1], row[2:]
    uniform = 1 / (ANGLES[-1] - ANGLES[0])
    stands_out = (before < here) & (here >= after) & (here > 2 * uniform)
    return [float(angle) for angle in ANGLES[1:-1][stands_out]]


def is_at(peak: float, places: tuple[float, float]) -> bool:
    """Return whether a peak is between two angles, within a kernel's width."""
    return places[0] - 0.1 < peak < places[1] + 0.1


def directions(stage: StageDocument) -> dict[str, tuple[float, float]]:
    """Return least and greatest pan angles to the presented object and to the window, rad."""
    robot, urdf = shipped_dexter()
    kinematics = Kinematics(robot, urdf)
    eyes = [kinematics.frame(camera.link).position for camera in robot.cameras.values()]
    x, y, _ = np.mean(eyes, axis=0)
    place, window = stage.contexts["presented"].place, stage.fixtures["window"]
    assert isinstance(place, PlaceSection) and isinstance(window.form, BoxForm)
    depth = max(window.form.size[1]) / 2
    stands_x, stands_y = (span[0] for span in window.position[:2])
    corners = {
        "presented": [(a, b) for a in place.x for b in place.y],
        "window": [(stands_x, stands_y + each) for each in (-depth, depth)],
    }
    angles = {
        name: [float(np.arctan2(b - y, a - x)) for a, b in found] for name, found in corners.items()
    }
    return {name: (min(found), max(found)) for name, found in angles.items()}


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> list[LearnedTrial]:
    """Run three full trials of SEARCHTRACK."""
    settings = RunSettings(seed=5, trials=3, folder=tmp_path_factory.mktemp("trials"))
    with trial_runner(settings) as dexter:
        return dexter.learn(COARTICULATED)


@pytest.mark.slow
@pytest.mark.parametrize("trial", range(3))
def test_learned_head_density_peaks_in_front_and_at_the_window_alone(
    trials: list[LearnedTrial], trial: int
) -> None:
    places = directions(trials[trial].stage)
    assert places["presented"][1] < 0.3 < 1.0 < places["window"][0]
    density = trials[trial].trial.learner.densities()["head"]
    row = marginal(density, 0, ANGLES)
    found = peaks(row)
    assert all(any(is_at(peak, place) for peak in found) for place in places.values())
    assert all(any(is_at(peak, place) for place in places.values()) for peak in found)
    for low, high in pairwise(sorted(places.values())):
        between = row[(low[1] < ANGLES) & (high[0] > ANGLES)]
        assert between.min() < 0.3 * np.interp(found, ANGLES, row).min()
    # Samples without one of the contexts lack its peak, and a uniform density has no peak.
    assert isinstance(density, Kernel)
    for name, (least, most) in places.items():
        others = [each for each in density.samples if not least - 0.3 < each[0] < most + 0.3]
        blind = density.model_copy(update={"samples": tuple(others)})
        assert 0 < len(others) < len(density.samples)
        assert not any(is_at(peak, places[name]) for peak in peaks(marginal(blind, 0, ANGLES)))
    assert peaks(np.full(len(ANGLES), 0.25)) == []


def test_prominence_of_peaks_is_measured_against_the_valley_between() -> None:
    angles = np.linspace(-1, 1, 201)
    front = angles < 0
    two = 0.1 + np.exp(-((angles + 0.5) ** 2) / 0.01) + 0.5 * np.exp(-((angles - 0.5) ** 2) / 0.01)
    even = np.full(201, 0.5)
    assert prominences(np.array([two, even]), front) == pytest.approx(
        np.array([[11, 6], [1, 1]]), rel=0.01
    )


@pytest.mark.parametrize("density", [KERNEL, GAUSSIAN], ids=["kernel", "gaussian"])
def test_rewards_anywhere_make_a_density_without_the_peaks(density: Kernel | Gaussian) -> None:
    rng, angles = np.random.default_rng(0), np.linspace(-2, 2, 401)
    rows = np.array([anywhere(Known(density, 200), 0, angles, rng) for _ in range(50)])
    assert rows.sum(axis=1) * (angles[1] - angles[0]) == pytest.approx(np.ones(50), abs=0.2)
    even = np.full(401, 1 / 4)
    spread = Expectation("joint", -2.0, 2.0, rows, rows[None]).deviations
    assert spread(rows).mean() == pytest.approx(spread(even), rel=0.2)

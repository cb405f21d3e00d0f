"""Load cells filter their samples at every sampling rate."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.staging.load_cells import ContactPoint, LoadCells, sum_wrenches
from cbdsl.documents.robot import Contact, RobotDocument

CELLS = (("hand", "a"), ("hand", "b"))


def _cells(seed: int = 0, rate: float = 240.0, ahead: int = 1, **contact: float) -> LoadCells:
    rng = np.random.default_rng(seed)
    return LoadCells(CELLS, Contact(**contact), (1 / rate, 1 / 240), rng, ahead)


def test_filter_passes_two_thirds_after_its_time_constant() -> None:
    wrenches = np.arange(12.0).reshape(2, 6)
    cells = _cells(noise=0, filter=6 / 240)
    for _ in range(6):
        cells.sample(wrenches)
    for cell, wrench in zip(CELLS, wrenches, strict=True):
        assert cells.read()[cell] == pytest.approx((1 - np.exp(-1)) * wrench)


def test_without_a_filter_readings_are_immediate() -> None:
    cells = _cells(noise=0, filter=0)
    cells.sample(np.ones((2, 6)))
    assert cells.read()["hand", "b"] == pytest.approx(np.ones(6))


def test_noise_has_the_stated_deviation() -> None:
    cells = _cells(noise=0.05, filter=0)
    readings = []
    for _ in range(2000):
        cells.sample(np.zeros((2, 6)))
        readings.append(cells.read()["hand", "a"])
    deviations = np.std(readings, axis=0)
    assert deviations[:3] == pytest.approx(0.05, rel=0.1)
    assert (deviations[3:] < 0.05 / 50).all()


def test_noise_that_is_drawn_ahead_is_the_same() -> None:
    one, other = _cells(noise=0.05), _cells(noise=0.05, ahead=64)
    for _ in range(100):
        one.sample(np.ones((2, 6)))
        other.sample(np.ones((2, 6)))
    assert (one.read().wrenches == other.read().wrenches).all()


@pytest.mark.parametrize("rate", [60.0, 15.0])
def test_filter_lags_as_much(dexter: RobotDocument, rate: float) -> None:
    wrenches = np.arange(12.0).reshape(2, 6)
    sampled = _cells(noise=0.0, filter=dexter.contact.filter)
    cells = _cells(rate=rate, noise=0.0, filter=dexter.contact.filter)
    for _ in range(4):
        cells.sample(wrenches)
        for _ in range(round(240 / rate)):
            sampled.sample(wrenches)
        for cell in CELLS:
            assert cells.read()[cell] == pytest.approx(sampled.read()[cell])


@pytest.mark.parametrize("time_constant", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("rate", [60.0, 15.0])
def test_as_much_noise_passes(rate: float, time_constant: float) -> None:
    nothing = np.zeros((2, 6))
    sampled = _cells(1, noise=0.05, filter=time_constant)
    cells = _cells(2, rate=rate, noise=0.05, filter=time_constant)
    readings, expected = [], []
    for _ in range(4000):
        cells.sample(nothing)
        readings.append(cells.read()["hand", "a"])
        for _ in range(round(240 / rate)):
            sampled.sample(nothing)
        expected.append(sampled.read()["hand", "a"])
    assert np.std(readings[100:], axis=0) == pytest.approx(np.std(expected[100:], axis=0), rel=0.15)


def test_reading_is_not_changed_by_the_next_sample() -> None:
    cells = _cells(noise=0.05)
    reading = cells.read()["hand", "a"]
    before = reading.copy()
    cells.sample(np.ones((2, 6)))
    assert (reading == before).all()


def test_contact_forces_are_summed_about_each_fingertip() -> None:
    one, other = CELLS
    touches = [
        ContactPoint(one, 0, (1.0, 0.0, 0.0), (0.0, 0.0, 2.0), 2.0),
        ContactPoint(one, 0, (0.0, 1.0, 0.0), (0.0, 0.0, 3.0), 3.0),
    ]
    sums = sum_wrenches(CELLS, touches, {one: (0.0, 0.0, 0.5), other: (9.0, 9.0, 9.0)})
    assert sums.tolist() == [[0, 0, 5, 3, -2, 0], [0] * 6]

"""Zeros of load cells: weight and bias are removed in every posture, and drift is followed."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.backends.staging.encoders import Encoders
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.touch.cell_zeros import CellZeros
from tests.backends.conftest import URDF, made_stage

PERIOD = 1 / 20


def zeros_of(dexter: RobotDocument, kinematics: Kinematics, **contact: float) -> CellZeros:
    links = [cell.link for hand in dexter.load_cells.values() for cell in hand.values()]
    changed = dexter.contact.model_copy(update=contact)
    return CellZeros(changed, kinematics, links)


def moved(backend: KinematicBackend, signals: Signals, ticks: int) -> list[float]:
    """Return the largest measured force, N, by tick, as arms and hands move in free space."""
    felt, start = [], backend.observe().positions
    for tick in range(ticks):
        swing = 0.6 * np.sin(2 * np.pi * tick / ticks)
        backend.apply(start + np.where(np.arange(len(start)) < 2, 0.0, swing))
        backend.step()
        signals.update(backend.observe())
        felt.append(float(np.linalg.norm(signals.touch.loads[:, :3], axis=1).max()))
    return felt


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_contact_is_measured_without_touch(
    dexter: RobotDocument, kinematics: Kinematics, seed: int
) -> None:
    """Cells without their zeros would feel several times the threshold."""
    backend = KinematicBackend(dexter, URDF)
    backend.reset(made_stage({}), None, np.random.default_rng(seed))
    signals = Signals(dexter, kinematics, ())
    signals.update(backend.observe())
    felt = moved(backend, signals, 400)
    raw = np.array(list(backend.observe().loads.values()))
    backend.close()
    assert max(felt) < dexter.contact.threshold
    assert np.linalg.norm(raw[:, :3], axis=1).max() > 2 * dexter.contact.threshold


def test_drift_is_followed_and_a_contact_is_not(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    zeros = zeros_of(dexter, kinematics)
    cells = sum(len(hand) for hand in dexter.load_cells.values())
    loads, feeling = np.zeros((cells, 6)), np.zeros(cells, dtype=bool)
    wrenches = np.zeros((cells, 6))
    zeros.remove(wrenches, 0.0, loads, feeling)
    # 1 N a minute: more than the threshold in all, and little in each time constant.
    for tick in range(1, 1201):
        wrenches[:, 1] = tick * PERIOD / 60
        assert not zeros.remove(wrenches, tick * PERIOD, loads, feeling)
    drifted = wrenches.copy()
    wrenches[0, 0] += 0.3
    for tick in range(1201, 2401):
        assert zeros.remove(wrenches, tick * PERIOD, loads, feeling)
    assert feeling.tolist() == [True] + [False] * (cells - 1)
    assert loads[0, 0] == pytest.approx(0.3)
    assert abs(loads[1:]).max() < 0.02 and abs(drifted[1:]).max() > 0.9


def test_first_measurement_is_the_bias(dexter: RobotDocument, kinematics: Kinematics) -> None:
    zeros = zeros_of(dexter, kinematics)
    cells = sum(len(hand) for hand in dexter.load_cells.values())
    loads, feeling = np.ones((cells, 6)), np.ones(cells, dtype=bool)
    wrenches = np.random.default_rng(0).normal(size=(cells, 6))
    assert not zeros.remove(wrenches, 0.0, loads, feeling)
    assert not loads.any() and not feeling.any()
    pressed = wrenches + np.array([2.0, 0, 0, 0, 0, 0])
    assert zeros.remove(pressed, 0.0, loads, feeling)
    assert loads == pytest.approx(np.tile([2.0, 0, 0, 0, 0, 0], (cells, 1)))


def test_encoders_of_a_hand_are_fine_enough_for_its_zeros(dexter: RobotDocument) -> None:
    """Encoder steps turn a cell's bias by less than its noise."""
    assert Encoders(dexter, PERIOD)._steps.max() * 3 * dexter.contact.bias < dexter.contact.noise


def at_rest(
    dexter: RobotDocument, kinematics: Kinematics, posture: np.ndarray, bias: np.ndarray
) -> np.ndarray:
    """Return weight and bias, N and N m, world frame: the measurement without contact."""
    kinematics.update(posture)
    rows = []
    for cell in (cell for hand in dexter.load_cells.values() for cell in hand.values()):
        turn, body = kinematics.frame(cell.link).rotation, kinematics.inertial(cell.link)
        assert body is not None
        force = np.array([0.0, 0.0, 9.81 * body.mass])
        torque = np.cross(turn @ np.array(body.origin.xyz), force)
        rows.append(np.r_[force + turn @ bias[:3], torque + turn @ bias[3:]])
    return np.array(rows)


def test_weight_and_bias_turn_with_their_cells(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    """Known in one posture, they are subtracted in any other."""
    zeros, rng = zeros_of(dexter, kinematics, threshold=50.0), np.random.default_rng(3)
    bias = rng.normal(size=6)
    cells = sum(len(hand) for hand in dexter.load_cells.values())
    loads, feeling = np.ones((cells, 6)), np.ones(cells, dtype=bool)
    for number in range(4):
        posture = rng.uniform(kinematics.lower, kinematics.upper)
        measured = at_rest(dexter, kinematics, posture, bias)
        if number:
            contact = rng.normal(size=(cells, 6))
            zeros.remove(measured + contact, 0.0, loads, feeling)
            np.testing.assert_allclose(loads, contact, atol=1e-9)
        else:
            zeros.remove(measured, 0.0, loads, feeling)
            assert not loads.any()


def test_bias_is_followed_with_its_time_constant(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    zeros = zeros_of(dexter, kinematics, threshold=1.0, zero_tracking=2.0)
    cells = sum(len(hand) for hand in dexter.load_cells.values())
    loads, feeling = np.zeros((cells, 6)), np.zeros(cells, dtype=bool)
    wrenches = np.zeros((cells, 6))
    zeros.remove(wrenches, 3.0, loads, feeling)
    wrenches[:, 4] = 0.5
    seen = []
    for time in (3.1, 3.3, 3.7):
        zeros.remove(wrenches, time, loads, feeling)
        seen.append(loads[:, 4].copy())
    fades = 0.5 * np.exp(-np.array([0.0, 0.1, 0.3]) / 2.0)
    np.testing.assert_allclose(seen, np.outer(fades, np.ones(cells)))
    other = zeros_of(dexter, kinematics, threshold=1.0, zero_tracking=2.0)
    other.resume(zeros)
    other.remove(wrenches, 0.0, loads, feeling)
    np.testing.assert_allclose(loads[:, 4], 0.5 * np.exp(-0.7 / 2.0))
    zeros.reset()
    zeros.remove(wrenches, 9.0, loads, feeling)
    assert not loads.any()


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("force", "felt"), [(0.99, False), (-1.01, True)])
def test_force_above_the_threshold_is_contact_in_any_direction(
    dexter: RobotDocument, kinematics: Kinematics, axis: int, force: float, felt: bool
) -> None:
    zeros = zeros_of(dexter, kinematics, threshold=1.0)
    cells = sum(len(hand) for hand in dexter.load_cells.values())
    loads, feeling = np.zeros((cells, 6)), np.zeros(cells, dtype=bool)
    wrenches = np.zeros((cells, 6))
    zeros.remove(wrenches, 0.0, loads, feeling)
    wrenches[2, axis], wrenches[:, 3:] = force, 5.0
    assert zeros.remove(wrenches, 0.0, loads, feeling) is felt
    assert feeling.tolist() == [number == 2 and felt for number in range(cells)]

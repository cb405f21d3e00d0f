"""Zeros of load cells: weight and bias are removed in every posture, and drift is followed."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.backends.staging.encoders import Encoders
from cbdsl.documents.robot import RobotDocument
from cbdsl.sensing.cell_zeros import CellZeros
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.sensing.signals import Signals
from tests.backends.conftest import URDF, made_stage

PERIOD = 1 / 20


def zeros_of(dexter: RobotDocument, kinematics: Kinematics, **contact: float) -> CellZeros:
    links = [cell.link for hand in dexter.load_cells.values() for cell in hand.values()]
    changed = dexter.contact.model_copy(update=contact)
    return CellZeros(changed, kinematics, links)


def moved(backend: KinematicBackend, signals: Signals, ticks: int) -> list[float]:
    """The largest force that is felt, N, tick by tick, while arms and hands move in free space."""
    felt, start = [], backend.observe().positions
    for tick in range(ticks):
        swing = 0.6 * np.sin(2 * np.pi * tick / ticks)
        backend.apply(start + np.where(np.arange(len(start)) < 2, 0.0, swing))
        backend.step()
        signals.update(backend.observe())
        felt.append(float(np.linalg.norm(signals.touch.loads[:, :3], axis=1).max()))
    return felt


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nothing_is_felt_while_nothing_is_touched(
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


def test_what_is_measured_first_is_taken_for_bias(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
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
    """A step turns a cell's bias by less than its noise."""
    assert Encoders(dexter, PERIOD)._steps.max() * 3 * dexter.contact.bias < dexter.contact.noise

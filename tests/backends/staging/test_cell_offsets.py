"""Load cells read a bias, its drift and the weight of the tips in every orientation."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.staging.cell_offsets import CellOffsets
from cbdsl.documents.robot import Contact
from cbdsl.kinematics.forward import rotation_of
from cbdsl.robot.urdf import UrdfInertial, UrdfLink, UrdfOrigin

TIP = UrdfLink("tip", (), (), UrdfInertial(0.02, (0.0,) * 6, UrdfOrigin(xyz=(0.01, 0.0, 0.0))))
NOTHING = np.zeros((1, 6))


def offsets(seed: int = 0, rate: float = 60.0, **contact: float) -> CellOffsets:
    rng = np.random.default_rng(seed)
    return CellOffsets([TIP], [1], Contact(**contact), 1 / rate, rng)


def placed(rotation: np.ndarray) -> np.ndarray:
    """Return placements of a base and of the tip, turned."""
    tip = np.concatenate([rotation.ravel(), [1.0, 2.0, 3.0]])
    return np.array([np.concatenate([np.eye(3).ravel(), np.zeros(3)]), tip])


def test_weight_is_borne_upwards_behind_its_lever() -> None:
    read = offsets(bias=0.0, drift=0.0)
    for turn in np.random.default_rng(1).normal(size=(5, 3)):
        rotation = rotation_of(turn)
        lever = rotation @ [0.01, 0.0, 0.0]
        force = np.array([0.0, 0.0, 0.02 * 9.81])
        expected = [*force, *np.cross(lever, force)]
        assert read.added(NOTHING, placed(rotation))[0] == pytest.approx(expected)


def test_bias_turns_with_its_cell() -> None:
    read, weight = offsets(bias=0.2, drift=0.0), offsets(bias=0.0, drift=0.0)
    here = np.eye(3)
    bias = (read.added(NOTHING, placed(here)) - weight.added(NOTHING, placed(here)))[0]
    assert 0.02 < np.linalg.norm(bias[:3]) < 1.0
    turned = rotation_of(np.array([0.3, -1.0, 0.5]))
    there = (read.added(NOTHING, placed(turned)) - weight.added(NOTHING, placed(turned)))[0]
    assert there == pytest.approx([*(turned @ bias[:3]), *(turned @ bias[3:])])


@pytest.mark.parametrize("rate", [60.0, 20.0])
def test_drift_has_its_deviation_at_any_rate(rate: float) -> None:
    """Compare walks: one of 4 s goes twice as far as one of 1 s."""
    wandered = []
    for seed in range(300):
        read = offsets(seed, rate, bias=0.0, drift=0.01)
        for _ in range(round(4 * rate)):
            read.drift()
        wandered.append(read.added(NOTHING, placed(np.eye(3)))[0, :2])
    assert np.std(wandered) == pytest.approx(0.02, rel=0.1)


def test_wrenches_of_contacts_are_added_to() -> None:
    read = offsets(bias=0.0, drift=0.0)
    wrenches = np.arange(6.0).reshape(1, 6)
    before = wrenches.copy()
    difference = read.added(wrenches, placed(np.eye(3))) - read.added(NOTHING, placed(np.eye(3)))
    assert difference == pytest.approx(before)
    assert (wrenches == before).all()

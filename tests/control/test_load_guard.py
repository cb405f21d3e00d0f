"""Load guards: the remaining motion towards a force, and the remaining pressing references."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.compiled_tick import MOVED
from cbdsl.control.load_guard import LOAD_GUARD
from cbdsl.control.potentials.spring import spring
from cbdsl.types.resource_type import POSITION
from tests.control.test_compiled_tick import ALL, JOINTS, Bench, Case, made

CASE = Case(spring("position", 3), made("spring", POSITION))
BOUND, PACE = 10.0, 2e-4  # N, m per tick


class Pressing:
    """Tip of three coordinates and five joints that moves along the force of its cells.

    Args:
        forces: Forces of its load cells, N, shape (cells, 3).
        lead: Lead of the references over the positions along the motion, rad.
        towards: Direction of the motion along the sum of the forces.
    """

    def __init__(self, forces: np.ndarray, *, lead: float = 0.0, towards: float = 1.0) -> None:
        rng = np.random.default_rng(3)
        self.bench = Bench([CASE], rng)
        self.bench.columns[0] = JOINTS
        reading = CASE.reading(rng)
        assert reading.jacobian is not None
        self.rows = reading.jacobian[:, JOINTS]
        self.way = forces.sum(axis=0)
        self.way /= np.linalg.norm(self.way)
        self.sideways = np.cross(self.way, [0.6, 0.0, 0.8])
        goal = reading.value + 0.2 * (towards * self.way + self.sideways)
        self.bench.write(0, reading, goal)
        self.before = np.zeros(ALL)
        self.before[JOINTS] = lead * self.rows.T @ self.way
        self.bench.references[:] = self.before
        # Two preceding cells belong to another hand, which the guard ignores.
        self.bench.loads = np.hstack(
            [np.vstack([[[7.0, 8.0, 9.0]], forces]), np.zeros((len(forces) + 1, 3))]
        )
        self.bench.load_guards = np.zeros(1, LOAD_GUARD)
        (self.guard,) = self.bench.load_guards
        self.bench.load_guards["first"], self.bench.load_guards["last"] = 1, len(forces) + 1
        self.bench.load_guards["row"] = self.bench.feedback[0]
        self.bench.load_guards["bound"], self.bench.load_guards["pace"] = BOUND, PACE

    def motion(self) -> np.ndarray:
        """Return the motion of the tip along the force and across it, m, in a tick."""
        assert self.bench.tick() == MOVED
        moved = self.rows @ self.bench.step.displacement
        return np.array([moved @ self.way, moved @ self.sideways])

    def kept(self) -> float:
        """Return the share of the references' lead along the motion that a tick leaves."""
        self.bench.tick()
        moved = self.bench.references[JOINTS] - self.bench.step.displacement
        return float((moved @ self.before[JOINTS]) / (self.before @ self.before))


def alone(size: float) -> np.ndarray:
    """Return forces of one cell."""
    return size * np.array([[0.36, -0.48, 0.8]])


@pytest.fixture
def free() -> np.ndarray:
    """Return the motion without a force."""
    return Pressing(alone(1e-9)).motion()


@pytest.mark.parametrize("share", [0.6, 0.9, 1.0, 1.5, 1.9, 2.5, 4.0])
def test_guarded_tip_slows_towards_the_bound_and_retreats_beyond_it(
    share: float, free: np.ndarray
) -> None:
    it = Pressing(alone(share * BOUND))
    along, across = it.motion()
    assert free[0] > 10 * PACE
    assert along == pytest.approx(PACE * max(1.0 - share, -1.0), abs=1e-9)
    assert across == pytest.approx(free[1], rel=1e-6)
    assert it.guard["held"] and it.guard["force"] == pytest.approx(share * BOUND)


@pytest.mark.parametrize("share", [0.1, 0.45])
def test_far_below_the_bound_a_guard_does_nothing(share: float, free: np.ndarray) -> None:
    it = Pressing(alone(share * BOUND))
    np.testing.assert_allclose(it.motion(), free, rtol=1e-9)
    assert not it.guard["held"] and it.guard["force"] == pytest.approx(share * BOUND)


def test_retreating_tip_is_not_changed_by_its_guard() -> None:
    away = Pressing(alone(1e-9), towards=-1.0).motion()
    it = Pressing(alone(1.5 * BOUND), towards=-1.0, lead=-0.1)
    np.testing.assert_allclose(it.motion(), away, rtol=1e-9)
    assert not it.guard["held"]


def test_forces_of_a_hand_add_up(free: np.ndarray) -> None:
    forces = np.vstack([alone(0.3 * BOUND), alone(0.5 * BOUND)])
    assert Pressing(forces).motion()[0] == pytest.approx(0.2 * PACE, abs=1e-9)
    forces = np.vstack([alone(5 * BOUND), alone(-4.9 * BOUND)])
    assert Pressing(forces).motion() == pytest.approx(free)


@pytest.mark.parametrize(("share", "kept"), [(0.9, 1.0), (1.1, 0.8), (3.0, 0.8)])
def test_references_ahead_of_the_tip_return_beyond_the_bound(share: float, kept: float) -> None:
    """Move references back along the force, as the joints feel it; lagging ones stay."""
    assert Pressing(alone(share * BOUND), lead=0.02).kept() == pytest.approx(kept)
    assert Pressing(alone(share * BOUND), lead=-0.02).kept() == pytest.approx(1.0)


def test_two_guards_of_one_tip_hold_together() -> None:
    """Bound the motion of one tip along two forces at right angles."""
    forces = np.array([[8.0, 0.0, 0.0], [0.0, 9.0, 0.0]])
    it = Pressing(forces)
    it.bench.load_guards = np.repeat(it.bench.load_guards, 2)
    it.bench.load_guards["first"], it.bench.load_guards["last"] = (1, 2), (2, 3)
    it.bench.tick()
    moved = it.rows @ it.bench.step.displacement
    np.testing.assert_allclose(moved[:2], [0.2 * PACE, 0.1 * PACE], atol=1e-9)
    assert it.bench.load_guards["held"].all()
    np.testing.assert_allclose(it.bench.load_guards["force"], [8.0, 9.0])


def test_joints_give_way_along_the_measured_torques() -> None:
    """Use as many rows as the guard has joints, in place of a tip and its cells."""
    by_cells, by_joints = (Pressing(alone(0.9 * BOUND), lead=0.1) for _ in range(2))
    guards = by_joints.bench.load_guards
    guards["first"] = guards["last"] = 0
    guards["joints"], guards["torques"][0, :3] = 3, alone(0.9 * BOUND)[0]
    guards["torques"][0, 3:] = 99.0  # of joints that another arm may have
    np.testing.assert_allclose(by_joints.motion(), by_cells.motion(), atol=1e-12)
    assert guards["held"][0] and guards["force"][0] == pytest.approx(0.9 * BOUND)

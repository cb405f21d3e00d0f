"""Guards bound the force of a motion, and let it be undone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.control.load_guard import JOINT_PACE, PACE
from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import Guards
from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.load_guards import LoadGuards
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from tests.runtime.test_relative import CELLS, PERIOD, POSITION, controller

STIFFNESS = 1000.0  # N/m of the floor at each fingertip


class Floor:
    """A hand that moves by one controller over an elastic floor, 3 cm below where it begins."""

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, path: Path, way: str, guards: Guards
    ) -> None:
        it = controller(path, f'{POSITION}, reference: "here + [0 cm, 0 cm, {way}]"')
        self.signals, plan = Signals(robot, kinematics, it.resources), ControllerPlan()
        self.run = ControllerRun(it, self.signals, plan, PERIOD)
        self.actuation = Actuation(robot, self.signals, plan, PERIOD, guards)
        self._active = (Active(self.run, {}),)
        starts = (e.postures[e.start or ""] for e in robot.effectors.values())
        self.q = np.array([angle for start in starts for angle in start])
        self.links = [cell.link for cell in robot.load_cells["right_hand"].values()]
        self._observe()
        self._floor = [z - 0.03 for z in self.heights()]
        self.actuation.reset(self.q)
        self.run.begin(np.random.default_rng(0))
        self.run.activate()

    def heights(self) -> list[float]:
        return [float(self.signals.kinematics.frame(link).position[2]) for link in self.links]

    def _observe(self, forces: list[float] | None = None) -> None:
        loads = {cell: np.zeros(6) for cell in CELLS}
        for finger, force in enumerate(forces or [0.0] * 3, 1):
            loads["right_hand", f"finger_{finger}"][2] = -force
        still = np.zeros_like(self.q)
        self.signals.update(Observation(0.0, self.q.copy(), still, loads, {}))

    def ticks(self, count: int) -> list[float]:
        """Return the largest force of a finger, N, tick by tick."""
        most = []
        for _ in range(count):
            depths = zip(self._floor, self.heights(), strict=True)
            forces = [STIFFNESS * max(0.0, floor - height) for floor, height in depths]
            self._observe(forces)
            self.actuation.move(self._active)
            self.q = self.actuation.reference.copy()
            most.append(max(forces))
        return most


@pytest.mark.parametrize("bound", [5.0, 12.0])
def test_guarded_motion_keeps_a_bound_that_it_exceeds_unguarded(
    dexter: RobotDocument, kinematics: Kinematics, tmp_path: Path, bound: float
) -> None:
    free = Floor(dexter, kinematics, tmp_path, "-12 cm", Guards())
    assert max(free.ticks(240)) > 50.0
    assert free.actuation.load_guards.clauses == ()
    guarded = Floor(dexter, kinematics, tmp_path, "-12 cm", Guards(finger_force=bound))
    forces = guarded.ticks(240)
    assert max(forces[-120:]) == pytest.approx(bound, rel=0.1)
    assert any(
        "finger_" in clause and "held for" in clause
        for clause in guarded.actuation.load_guards.clauses
    )
    assert guarded.actuation.load_guards.holding


def test_net_force_of_a_hand_is_bounded(
    dexter: RobotDocument, kinematics: Kinematics, tmp_path: Path
) -> None:
    guarded = Floor(dexter, kinematics, tmp_path, "-12 cm", Guards(hand_force=9.0))
    guarded.ticks(240)
    loads = guarded.signals.touch.loads[:, 2].sum()
    assert abs(loads) == pytest.approx(9.0, rel=0.15)
    (clause,) = guarded.actuation.load_guards.clauses
    assert clause.startswith("the guard of right_hand (9 N) held for")


def test_guard_does_not_prevent_leaving_contact(
    dexter: RobotDocument, kinematics: Kinematics, tmp_path: Path
) -> None:
    guarded = Floor(dexter, kinematics, tmp_path, "4 cm", Guards(finger_force=5.0))
    guarded._floor = [height + 0.004 for height in guarded.heights()]  # it begins with 4 N
    forces = guarded.ticks(60)
    assert forces[0] == pytest.approx(4.0, rel=0.01) and forces[-1] == 0.0


def test_narrowest_bounds_hold() -> None:
    assert Guards(15.0, None).within(Guards(8.0, 30.0)) == Guards(8.0, 30.0)


def test_measured_torque_fades_from_at_most_the_bound(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    """Adopt a stronger blow at once; one beyond the bound fades as if it had been at the bound."""
    signals = Signals(dexter, kinematics, ())
    felt, own = signals.strain.torques, kinematics.joints.of("right_arm")
    guards = LoadGuards(Guards(joint_torque=20.0), signals, PERIOD)
    place = guards.names.index("right_arm")
    assert signals.strain.needed and set(guards.units) == {"N m"}
    assert guards.records["joints"][place] == len(own)
    assert guards.records["pace"][place] == pytest.approx(JOINT_PACE * PERIOD)

    def size() -> float:
        guards.note_strain()
        return float(np.linalg.norm(guards.records["torques"][place]))

    felt[own[:2]] = 3.0, 4.0
    assert size() == pytest.approx(5.0)
    felt[own[:2]] = 0.0
    faded = [size() for _ in range(60)]
    assert faded[-1] == pytest.approx(5.0 * np.exp(-60 * PERIOD / 3.0))
    np.testing.assert_allclose(
        guards.records["torques"][place][:2], faded[-1] * np.array([0.6, 0.8])
    )
    felt[own[2]] = -50.0
    assert size() == pytest.approx(50.0)
    felt[own[2]] = 0.0
    assert size() == pytest.approx(20.0 * np.exp(-PERIOD / 3.0))
    guards.reset()
    assert size() == 0.0


def test_how_long_and_how_hard_a_guard_held_is_reported(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    bounds = Guards(finger_force=5.0, hand_force=9.0, joint_torque=20.0)
    guards = LoadGuards(bounds, Signals(dexter, kinematics, ()), PERIOD)
    cells = [f"{hand}.{each}" for hand, own in dexter.load_cells.items() for each in own]
    assert set(guards.names) >= {*cells, *dexter.load_cells, "left_arm", "right_arm"}
    place, arm = guards.names.index("left_hand"), guards.names.index("left_arm")
    first, last = guards.records["first"][place], guards.records["last"][place]
    assert last - first == 3 and guards.records["bound"][place] == 9.0
    assert guards.records["pace"][place] == pytest.approx(PACE * PERIOD)
    for force, held in ((12.0, True), (15.0, True), (10.0, False)):
        guards.records["force"][place], guards.records["held"][place] = force, held
        guards.records["force"][arm], guards.records["held"][arm] = 2 * force, held
        assert guards.holding == (("left_hand", "left_arm") if held else ())
        guards.note()
    assert set(guards.clauses) == {
        f"the guard of left_hand (9 N) held for {2 * PERIOD:.1f} s, at 15.0 N at most",
        f"the guard of left_arm (20 N m) held for {2 * PERIOD:.1f} s, at 30.0 N m at most",
    }
    guards.reset()
    assert not guards.clauses and not guards.holding

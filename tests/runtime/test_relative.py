"""References relative to the activation, and displaced from resources."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.program import check_program
from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.rotation import exp
from cbdsl.program.controller import Controller
from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals

PERIOD = 1 / 60
CELLS = [(f"{side}_hand", f"finger_{i}") for side in ("left", "right") for i in (1, 2, 3)]


def controller(tmp_path: Path, body: str) -> Controller:
    """Return the one controller of a program."""
    path = tmp_path / "programs" / "one.yaml"
    path.parent.mkdir(exist_ok=True)
    text = f"cbdsl: 1\nkind: program\nname: one\nrobot: dexter\ncontrollers:\n  it: {{{body}}}\n"
    path.write_text(text + "actions: [it]\n")
    return check_program(path).primitives["it"].lead


class Arm:
    """Controller of the right arm, whose joints follow their references at once.

    Attributes:
        force: Force on each of the right fingertips, N, world frame, shape (3,).
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, it: Controller) -> None:
        self.signals, plan = Signals(robot, kinematics, it.resources), ControllerPlan()
        self.run = ControllerRun(it, self.signals, plan, PERIOD)
        self.actuation = Actuation(robot, self.signals, plan, PERIOD)
        self._active = (Active(self.run, {}),)
        self._q = np.array(
            [
                angle
                for effector in robot.effectors.values()
                for angle in effector.postures[effector.start or ""]
            ]
        )
        self.force = np.zeros(3)
        self._ticks = 0
        self.actuation.reset(self._q)
        self.run.begin(np.random.default_rng(0))
        self.observe()
        self.run.activate()

    def observe(self) -> None:
        forces = {cell: np.zeros(6) for cell in CELLS}
        for finger in (1, 2, 3):
            forces["right_hand", f"finger_{finger}"][:3] = self.force
        still = np.zeros_like(self._q)
        self.signals.update(Observation(self._ticks * PERIOD, self._q.copy(), still, forces, {}))
        self._ticks += 1

    def move(self, seconds: float) -> str:
        """Let the controller act; returns its predicate."""
        for _ in range(round(seconds / PERIOD)):
            self.observe()
            self.actuation.move(self._active)
            self._q = self.actuation.reference.copy()
        return self.run.predicate

    @property
    def tip(self) -> np.ndarray:
        self.observe()
        return self.signals.tips.point("right_arm").position

    @property
    def rotation(self) -> np.ndarray:
        self.observe()
        return self.signals.tips.frame("right_arm").rotation


@pytest.fixture
def arm(dexter: RobotDocument, kinematics: Kinematics, tmp_path: Path):  # type: ignore[no-untyped-def]
    return lambda body: Arm(dexter, kinematics, controller(tmp_path, body))


POSITION = "potential: spring, feedback: right_arm.position, effector: right_arm.position"


def test_here_is_the_feedback_at_each_activation(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(POSITION + ', reference: "here + [2 cm, 0 cm, 5 cm]"')
    start = it.tip
    for turn in (1, 2):
        assert it.move(3.0) == "1"
        np.testing.assert_allclose(it.tip - start, turn * np.array([0.02, 0, 0.05]), atol=2e-4)
        it.run.activate()  # goes on, since it was not left
        it.move(0.5)
        np.testing.assert_allclose(it.tip - start, turn * np.array([0.02, 0, 0.05]), atol=2e-4)
        it.run.deactivate()
        it.run.activate()


def test_relative_reference_along_one_axis_leaves_others_free(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(POSITION + ", reference: here - 5 cm, axes: [z]")
    start = it.tip
    it.move(3.0)
    assert (it.tip - start)[2] == pytest.approx(-0.05, abs=2e-4)
    assert it.run.size == 1


def test_orientation_is_turned_in_world_axes(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(
        "potential: spring, feedback: right_arm.orientation, effector: right_arm.orientation, "
        'reference: "here + [0 deg, 0 deg, 20 deg]"'
    )
    start = it.rotation.copy()
    it.move(3.0)
    np.testing.assert_allclose(
        it.rotation, exp(np.array([0, 0, np.radians(20)])) @ start, atol=2e-3
    )


def test_resource_is_displaced_by_a_constant(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(
        'potential: spring, reference: "left_arm.position + [0 cm, -40 cm, 3 cm]", '
        "feedback: right_arm.position, effector: right_arm.position"
    )
    it.move(4.0)
    goal = it.signals.tips.point("left_arm").position - [0, 0.4, -0.03]
    np.testing.assert_allclose(it.tip, goal, atol=5e-4)


HELD = (
    "potential: spring, reference: here - 2 N, axes: [z], feedback: right_hand.net.force, "
    "effector: right_arm.position, onset: {change: 1 N}, gain: 1 /s"
)


def test_load_is_undefined_until_it_changes(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(HELD)
    assert it.move(0.5) == "-"  # nothing is held
    it.force = np.array([0.0, 0.0, 0.8])
    assert it.move(2.0) == "-"  # 2.4 N hang from the hand
    before = it.tip[2]
    it.force = np.array([0.0, 0.0, 0.4])
    assert it.move(0.3) == "0"  # 1.2 N of which something bears: 0.8 N too few
    assert it.run.error == pytest.approx(0.8, abs=0.1)
    assert it.tip[2] < before
    it.force = np.array([0.0, 0.0, 2.4 / 3 - 2 / 3])
    it.move(1.0)
    assert it.run.error == pytest.approx(0.0, abs=0.1)
    it.force = np.zeros(3)
    assert it.move(0.1) == "-"  # it has let go


def test_onset_of_a_load_is_cleared_at_activation(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(HELD)
    it.force = np.array([0.0, 0.0, 0.8])
    it.move(1.0)
    it.force = np.array([0.0, 0.0, 0.3])
    assert it.move(0.3) == "0"
    it.run.deactivate()
    it.run.activate()
    assert it.move(1.0) == "-"


def test_evaluation_is_the_potential_of_the_tick(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(POSITION + ', reference: "here + [2 cm, 0 cm, 5 cm]"')
    assert it.run.evaluate() is None, "before the first tick"
    it.move(0.1)
    found = it.run.evaluate()
    assert found.phi == pytest.approx(it.run.phi)
    assert np.linalg.norm(found.residual) == pytest.approx(it.run.error)
    tip = it.signals.tips.point("right_arm")
    np.testing.assert_allclose(found.residual, it.run.reference - tip.position, atol=1e-12)
    # The residual's slope is the negative one of the position, of either sign by convention.
    own = np.abs(tip.jacobian[:3, it.run.columns[it.run.columns >= 0]])
    np.testing.assert_allclose(np.abs(found.jacobian[:, it.run.columns >= 0]), own, atol=1e-12)


def test_reference_is_held_and_given_back(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(POSITION + ', reference: "here + [2 cm, 0 cm, 5 cm]"')
    it.move(0.1)
    own, start = it.run.reference, it.tip
    it.run.hold_reference(np.add(start, [0.0, 0.0, 0.03]))
    it.move(3.0)
    np.testing.assert_allclose(it.tip - start, [0, 0, 0.03], atol=2e-4)
    it.run.hold_reference(start)
    np.testing.assert_allclose(it.run.reference, start)
    it.run.hold_reference(None)
    np.testing.assert_allclose(it.run.reference, own)
    it.move(3.0)
    np.testing.assert_allclose(it.tip, own, atol=2e-4)


def test_onset_uses_the_speed_of_the_tip(arm) -> None:  # type: ignore[no-untyped-def]
    it = arm(HELD)
    it.force = np.array([0.0, 0.0, 0.8])
    it.move(0.1)
    carrier = it.run.needs[-1]
    assert it.run.needs[:-1] == tuple(row for row in it.run.rows if row >= 0)
    it.observe()
    it.signals.refresh(it.signals.select([carrier]))
    tip = it.signals.tips.point("right_arm").position
    np.testing.assert_allclose(it.signals.table.values(carrier), tip, atol=1e-12)

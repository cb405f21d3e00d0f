"""Forces in the units of the tip that presses: m/s per N, and m/s."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.control.plan import ControllerPlan
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from tests.runtime.test_relative import CELLS, PERIOD, controller

PRESS = (
    "potential: spring, reference: -3 N, axes: [z], feedback: right_hand.net.force, "
    "effector: right_arm.position"
)


@pytest.mark.parametrize(
    ("units", "pace"),
    [
        ("gain: 2 mm/s/N, speed: 10 cm/s", 0.004),  # m/s, for an error of 2 N
        ("gain: 5 mm/s/N, speed: 10 cm/s", 0.01),
        ("gain: 5 mm/s/N, speed: 6 mm/s", 0.006),
    ],
)
def test_tip_moves_as_fast_as_its_units_say(
    dexter: RobotDocument, kinematics: Kinematics, tmp_path: Path, units: str, pace: float
) -> None:
    it = controller(tmp_path, f"{PRESS}, {units}")
    signals, plan = Signals(dexter, kinematics, it.resources), ControllerPlan()
    run = ControllerRun(it, signals, plan, PERIOD)
    actuation = Actuation(dexter, signals, plan, PERIOD)
    starts = (e.postures[e.start or ""] for e in dexter.effectors.values())
    q = np.array([angle for start in starts for angle in start])
    loads = {cell: np.zeros(6) for cell in CELLS}
    signals.update(Observation(0.0, q, np.zeros_like(q), loads, {}))
    actuation.reset(q)
    run.begin(np.random.default_rng(0))
    run.activate()
    loads["right_hand", "finger_1"] = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    active, heights = (Active(run, {}),), []
    for tick in range(1, 41):
        place = actuation.reference.copy()
        signals.update(Observation(tick * PERIOD, place, np.zeros_like(q), loads, {}))
        heights.append(kinematics.frame("right_palm").position[2])
        actuation.move(active)
    assert np.diff(heights)[20:].mean() / PERIOD == pytest.approx(-pace, rel=0.1)

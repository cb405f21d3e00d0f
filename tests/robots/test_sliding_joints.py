"""Sliding joints are reported in units of length."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.diagnostics.errors import DiagnosticsError
from tests.robots.small_robot import Hinge, SmallRobot, chain, write_robot

SLIDE = Hinge("prismatic", '<limit lower="0" upper="0.04" effort="50" velocity="3"/>')
MOVE = "move: {{potential: spring, reference: {}, feedback: grip, effector: grip}}"


def gripper(folder: Path) -> SmallRobot:
    effector = "effectors:\n  grip: {joints: [j1], postures: {open: [3 cm]}}"
    return write_robot(folder, chain(SLIDE), effector)


def test_ending_of_joints_that_slide_is_in_mm(tmp_path: Path) -> None:
    small = gripper(tmp_path)
    with small.backend("kinematic") as backend:
        ending = small.run(backend, MOVE.format("grip.open")).ending
    assert " mm from grip.open" in ending and "deg" not in ending


def test_reference_beyond_a_slide_is_reported_in_m(tmp_path: Path) -> None:
    small = gripper(tmp_path)
    with small.backend("kinematic") as backend, pytest.raises(DiagnosticsError) as told:
        small.run(backend, MOVE.format("[0.5]"))
    (diagnostic,) = told.value.diagnostics
    assert (
        diagnostic.code == "CB517"
        and "0.04 m" in diagnostic.message
        and "rad" not in diagnostic.message
    )

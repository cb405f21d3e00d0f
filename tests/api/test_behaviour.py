"""Behaviour of py_trees: a program's predicate is its status, and one robot runs several."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import cbdsl

py_trees = pytest.importorskip("py_trees")
from py_trees.common import Status  # noqa: E402

from cbdsl.api.behaviour import STATUS, ProgramBehaviour  # noqa: E402


@pytest.fixture
def robot() -> Iterator[cbdsl.OpenRobot]:
    with cbdsl.open_robot("searchtrack", backend="kinematic", persistent=True) as robot:
        yield robot


def ticked(tree: py_trees.behaviour.Behaviour, most: int = 3000) -> int:
    """Tick a tree until it has ended; how often."""
    for count in range(1, most):
        tree.tick_once()
        if tree.status is not Status.RUNNING:
            return count
    raise AssertionError("it never ends")


def test_predicates_are_statuses(robot: cbdsl.OpenRobot) -> None:
    assert STATUS == {
        "X": Status.INVALID, "-": Status.FAILURE, "0": Status.RUNNING, "1": Status.SUCCESS,
    }  # fmt: skip
    behaviour = ProgramBehaviour(robot, seed=11)
    assert behaviour.name == "searchtrack" and behaviour.status is Status.INVALID
    count = ticked(behaviour)
    assert behaviour.status is Status.SUCCESS
    assert behaviour.result is not None and behaviour.result.rewarded
    assert count == behaviour.result.ticks + 1
    assert behaviour.feedback_message == behaviour.result.ending


def test_what_cannot_be_done_fails() -> None:
    request = cbdsl.load("searchtrack")
    from dataclasses import replace

    hurried = replace(request, program=request.program._replace(transitions=1))
    with cbdsl.open_robot(hurried, backend="kinematic") as robot:
        behaviour = ProgramBehaviour(robot, seed=11)
        ticked(behaviour)
        assert behaviour.status is Status.FAILURE


def test_programs_share_a_robot_one_after_another(robot: cbdsl.OpenRobot) -> None:
    """The arm moves where the first program left the head, which stays there."""
    posture = robot.with_program(cbdsl.load("posture", stage="table_right"))
    look, move = ProgramBehaviour(robot, seed=11), ProgramBehaviour(posture, seed=11)
    tree = py_trees.composites.Sequence("both", memory=True, children=[look, move])
    while look.status is not Status.SUCCESS:
        tree.tick_once()
    neck = [robot.kinematics.joints.index[name] for name in ("pan", "tilt")]
    first = robot.backend.observe().positions.copy()
    ticked(tree)
    assert tree.status is Status.SUCCESS
    moved = abs(robot.backend.observe().positions - first)
    assert moved.max() > 0.05, "the arm moved"
    assert abs(first[neck]).max() > 0.05 and moved[neck].max() < 0.01


def test_what_is_interrupted_halts_and_begins_anew(robot: cbdsl.OpenRobot) -> None:
    behaviour = ProgramBehaviour(robot, seed=11)
    for _ in range(5):
        behaviour.tick_once()
    behaviour.stop(Status.INVALID)
    assert behaviour.status is Status.INVALID and behaviour.result is None
    ticked(behaviour)
    assert behaviour.status is Status.SUCCESS

"""Behaviour of py_trees: a program's predicate is its status, and one robot runs several."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import cbdsl
from cbdsl.diagnostics.errors import UsageError

py_trees = pytest.importorskip("py_trees")
from py_trees.common import Status  # noqa: E402

from cbdsl_trees.behaviour import STATUS, ProgramBehaviour  # noqa: E402


@pytest.fixture
def robot() -> Iterator[cbdsl.OpenRobot]:
    with cbdsl.open_robot("searchtrack", backend="kinematic", persistent=True) as robot:
        yield robot


def ticked(tree: py_trees.behaviour.Behaviour, most: int = 3000) -> int:
    """Tick a tree until it has ended; return the number of ticks."""
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


def test_feedback_tells_each_transition_in_words() -> None:
    with cbdsl.open_robot("pick", backend="kinematic") as robot:
        behaviour, told = ProgramBehaviour(robot, seed=11), []
        for _ in range(3000):
            behaviour.tick_once()
            if behaviour.feedback_message not in told[-1:]:
                told.append(behaviour.feedback_message)
            if behaviour.status is not Status.RUNNING:
                break
    assert behaviour.result is not None
    assert told[0] == "pick: grasp begins" and told[-1] == behaviour.result.ending
    assert "pick: grasp -> hold, since grasp succeeded" in told


def test_program_without_an_action_returns_failure() -> None:
    request = cbdsl.load("searchtrack")
    from dataclasses import replace

    hurried = replace(request, program=request.program._replace(transitions=1))
    with cbdsl.open_robot(hurried, backend="kinematic") as robot:
        behaviour = ProgramBehaviour(robot, seed=11)
        ticked(behaviour)
        assert behaviour.status is Status.FAILURE


def test_programs_share_a_robot_one_after_another(robot: cbdsl.OpenRobot) -> None:
    """Move the arm by the second program while the head stays where the first one left it."""
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


def test_interrupted_behaviour_halts_and_restarts(robot: cbdsl.OpenRobot) -> None:
    behaviour = ProgramBehaviour(robot, seed=11)
    for _ in range(5):
        behaviour.tick_once()
    behaviour.stop(Status.INVALID)
    assert behaviour.status is Status.INVALID and behaviour.result is None
    ticked(behaviour)
    assert behaviour.status is Status.SUCCESS


@pytest.mark.parametrize("backend", ["kinematic", "mujoco"])
def test_two_behaviours_of_one_robot_in_a_parallel_are_an_error(backend: str) -> None:
    with cbdsl.open_robot(
        "searchtrack", backend=backend, cameras="ideal", persistent=True
    ) as robot:
        posture = robot.with_program(cbdsl.load("posture", stage="table_right"))
        children = [ProgramBehaviour(robot, seed=11), ProgramBehaviour(posture, seed=11)]
        policy = py_trees.common.ParallelPolicy.SuccessOnAll()
        tree = py_trees.composites.Parallel("both", policy=policy, children=children)
        with pytest.raises(UsageError, match=r"behaviour 'posture' has begun.*compose them"):
            ticked(tree)


def test_selector_takes_the_robot_from_a_lower_priority(robot: cbdsl.OpenRobot) -> None:
    """Start the higher-priority behaviour before the lower one is interrupted."""
    posture = robot.with_program(cbdsl.load("posture", stage="table_right"))
    is_urgent = [False]

    class Urgent(py_trees.behaviour.Behaviour):
        def update(self) -> Status:
            return Status.SUCCESS if is_urgent[0] else Status.FAILURE

    look, move = ProgramBehaviour(robot, seed=11), ProgramBehaviour(posture, seed=11)
    urgent = py_trees.composites.Sequence("urgent", memory=False, children=[Urgent("?"), move])
    tree = py_trees.composites.Selector("tree", memory=False, children=[urgent, look])
    for _ in range(5):
        tree.tick_once()
    assert look.status is Status.RUNNING
    is_urgent[0] = True
    tree.tick_once()
    assert (move.status, look.status) == (Status.RUNNING, Status.INVALID)
    ticked(tree)
    assert move.status is Status.SUCCESS
    is_urgent[0] = False
    ticked(tree)
    assert look.status is Status.SUCCESS


def test_behaviour_of_a_closed_robot_is_an_error() -> None:
    with cbdsl.open_robot("searchtrack", backend="kinematic") as robot:
        behaviour = ProgramBehaviour(robot, seed=11)
        behaviour.tick_once()
    with pytest.raises(UsageError, match="its robot was closed"):
        behaviour.tick_once()
    behaviour.stop(Status.INVALID)
    with pytest.raises(UsageError, match="this robot is closed"):
        behaviour.tick_once()

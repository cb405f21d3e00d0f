"""Open robots: one episode at a time, and nothing once they are closed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

import cbdsl
from cbdsl.diagnostics.errors import UsageError


@pytest.fixture
def robot() -> Iterator[cbdsl.OpenRobot]:
    with cbdsl.open_robot("searchtrack", backend="kinematic", persistent=True) as robot:
        yield robot


USES: dict[str, Callable[[cbdsl.OpenRobot], Any]] = {
    "run": lambda robot: robot.run(1),
    "ticks": lambda robot: next(robot.ticks(1)),
    "with_program": lambda robot: robot.with_program("posture"),
    "backend": lambda robot: robot.backend.observe(),
}


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "bullet"])
@pytest.mark.parametrize("use", USES)
def test_run_on_a_closed_robot_is_refused(backend: str, use: str) -> None:
    with cbdsl.open_robot("searchtrack", backend=backend, cameras="ideal") as robot:
        other = robot.with_program("searchtrack")
    for each in (robot, other):
        with pytest.raises(UsageError, match="this robot is closed"):
            USES[use](each)


def test_episode_of_a_closed_robot_cannot_go_on() -> None:
    with cbdsl.open_robot("searchtrack", backend="kinematic") as robot:
        ticks = robot.ticks(1)
        next(ticks)
    with pytest.raises(UsageError, match="'searchtrack' cannot go on: its robot was closed"):
        next(ticks)


def test_episode_that_never_began_does_not_begin_on_a_closed_robot() -> None:
    with cbdsl.open_robot("searchtrack", backend="kinematic") as robot:
        ticks = robot.ticks(1)
    with pytest.raises(UsageError, match="this robot is closed"):
        next(ticks)


def test_second_episode_of_a_body_is_refused_while_one_runs(robot: cbdsl.OpenRobot) -> None:
    posture = robot.with_program(cbdsl.load("posture", stage="table_right"))
    ticks = robot.ticks(1)
    next(ticks)
    for other in (robot, posture):
        for use in (USES["run"], USES["ticks"]):
            with pytest.raises(UsageError, match="cannot begin while 'searchtrack' runs"):
                use(other)
    next(ticks)
    ticks.close()
    assert posture.run(1).ending


def test_episode_that_is_over_interrupted_or_dropped_leaves_the_body_free(
    robot: cbdsl.OpenRobot,
) -> None:
    for _ in robot.ticks(1):
        break
    ticks = robot.ticks(1)
    next(ticks)
    robot.interrupt("somebody pressed a button")
    with pytest.raises(UsageError, match="cannot go on: somebody pressed a button"):
        next(ticks)
    assert robot.run(1).rewarded and robot.run(2).rewarded
    robot.interrupt()
    unused = robot.ticks(3)
    unused.close()
    assert list(unused) == []


def test_episode_can_be_interrupted_from_within(robot: cbdsl.OpenRobot) -> None:
    def stop(tick: object) -> None:
        robot.interrupt("enough")

    with pytest.raises(UsageError, match="enough"):
        robot.run(1, on_tick=stop)
    assert robot.run(1).rewarded


def test_ticks_and_a_run_are_the_same_episode() -> None:
    with cbdsl.open_robot("searchtrack", backend="kinematic") as robot:
        whole = robot.run(5)
    with cbdsl.open_robot("searchtrack", backend="kinematic") as robot:
        ticks = robot.ticks(5)
        while True:
            try:
                next(ticks)
            except StopIteration as ended:
                result = ended.value
                break
    assert (result.predicates, result.actions, result.ticks) == (
        whole.predicates, whole.actions, whole.ticks,
    )  # fmt: skip

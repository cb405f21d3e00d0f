"""Guard: watchdogs at the topics of forward controllers."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from cbdsl.backends.backend import BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.guard import Guard
from cbdsl_ros2.ros_node import RosNode
from tests.driven_robot import URDF, robot

_PATIENCE = 5.0
NAMES = ["j2", "j1"]
# A robot that stands at its references, with other names in messages; nothing is late on a busy
# computer.
DOCUMENT = robot(form="positions", joints={"first": "j1", "second": "j2"}, deadline=2.0)
PROMPT = robot(form="positions", joints={"first": "j1", "second": "j2"}, deadline=0.2)


class Controller:
    """Forward controller of a robot, and a program that commands it."""

    def __init__(self, node: RosNode) -> None:
        self._states = node.writer("/joint_states", msg.JointState)
        self._program = node.writer("/commands/guarded", msg.Float64MultiArray)
        self._reader = node.reader("/commands", msg.Float64MultiArray, reliable=True)
        self.received: list[list[float]] = []

    def work(self, state: list[float], asked: list[float], names: list[str] = NAMES) -> None:
        """Publish a state and references, and take the watchdog's references."""
        header = msg.Header(stamp=msg.Time.of(time.time()))
        self._states.write(msg.JointState(header, names, state, [], []))
        self._program.write(msg.Float64MultiArray(data=asked))
        self.received += [list(m.data) for m in self._reader.take(64) if m.sample_info.valid_data]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "rail.urdf"
    path.write_text(URDF)
    return path


def guarded(
    path: Path, work: Callable[[], bool], document: RobotDocument = DOCUMENT
) -> tuple[bool, list[str]]:
    """Run a guard until work is done; return whether it held, and its lines."""
    guard, lines, until = Guard(document, path), list[str](), time.monotonic() + _PATIENCE
    try:
        held = guard.watch(lines.append, lambda: work() or time.monotonic() > until)
    finally:
        guard.close()
    return held, lines


def test_guard_forwards_references_by_the_order_of_the_driver(node: RosNode, path: Path) -> None:
    controller = Controller(node)

    def work() -> bool:
        # The state names the second joint first; references are in the driver's order.
        controller.work([-0.5, 0.2], [0.21, -0.52])
        return bool(controller.received) and np.allclose(controller.received[-1], [0.21, -0.52])

    held, lines = guarded(path, work)
    assert not held
    assert lines == ["driver 'arm' repeats"]
    assert np.allclose(controller.received[-1], [0.21, -0.52])
    steps = np.diff([[0.2, -0.5], *controller.received], axis=0)
    assert np.abs(steps).max() <= 0.02, "references approach within the limits"


@pytest.mark.parametrize(
    ("state", "names"),
    [([math.nan, 0.0], NAMES), ([0.0], ["j1"]), ([0.0], NAMES), ([0.0, 0.0], ["first", "second"])],
)
def test_guard_without_positions_of_all_joints_sends_nothing(
    state: list[float], names: list[str], node: RosNode, path: Path
) -> None:
    controller, count = Controller(node), 0

    def work() -> bool:
        nonlocal count
        count += 1
        controller.work(state, [0.0, 0.0], names)
        return count > 15

    held, lines = guarded(path, work)
    assert (held, lines, controller.received) == (False, [], [])


def test_guard_ignores_references_for_other_joints(node: RosNode, path: Path) -> None:
    controller, count = Controller(node), 0

    def work() -> bool:
        nonlocal count
        count += 1
        controller.work([0.0, 0.0], [0.0, 0.0, 0.0])
        return count > 15

    assert guarded(path, work) == (False, [])
    assert controller.received == []


def test_guard_holds_and_stops_without_a_program(node: RosNode, path: Path) -> None:
    controller = Controller(node)

    def work() -> bool:
        if len(controller.received) < 5:
            controller.work([0.0, 0.0], [0.8 if controller.received else 0.0, 0.0])
        else:
            controller._reader.take(64)
        return False

    held, lines = guarded(path, work, PROMPT)
    assert held
    assert lines[0] == "driver 'arm' repeats"
    assert lines[1].startswith("driver 'arm' holds: no reference for ")
    assert lines[2].startswith("driver 'arm' has stopped: ")


@pytest.mark.parametrize("rival", [False, True])
def test_guard_waits_for_the_next_episode_without_a_rival(
    rival: bool, node: RosNode, path: Path
) -> None:
    controller, rivals, ticks = Controller(node), list[object](), iter(range(150))

    def work() -> bool:
        tick = next(ticks) if controller.received else 0
        # An episode ends at tick 10, and the next one begins at tick 100.
        controller.work([0.0, 0.0], [] if 10 < tick < 100 else [0.0, 0.0])
        if tick == 60 and rival:
            rivals.append(node.writer("/commands/guarded", msg.Float64MultiArray))
        return tick > 140

    held, lines = guarded(path, work, PROMPT)
    assert not held
    waits = "driver 'arm' waits for the first reference"
    again = [] if rival else ["driver 'arm' repeats"]
    assert lines == ["driver 'arm' repeats", waits, *again]


@pytest.mark.parametrize("topic", ["/commands", "/commands/guarded"])
def test_guard_stops_beside_another_commander(topic: str, node: RosNode, path: Path) -> None:
    controller, rivals = Controller(node), []

    def work() -> bool:
        controller.work([0.0, 0.0], [0.0, 0.0])
        if controller.received and not rivals:
            rivals.append(node.writer(topic, msg.Float64MultiArray))
        return False

    held, lines = guarded(path, work)
    assert held
    process = f"process {os.getpid()}"
    names = process if topic == "/commands" else f"{process}, {process}"
    assert lines[1:] == [f"driver 'arm' has stopped: another commander writes to {topic} ({names})"]


def test_guard_does_not_start_beside_another_commander(node: RosNode, path: Path) -> None:
    rival, controller = node.writer("/commands", msg.Float64MultiArray), Controller(node)

    def work() -> bool:
        controller.work([0.0, 0.0], [0.0, 0.0])
        return False

    held, lines = guarded(path, work)
    assert held and rival
    assert lines[0].startswith("driver 'arm' has stopped: another commander writes to /commands")
    assert controller.received == []


@pytest.mark.parametrize("driver", [{}, {"kind": "echo", "form": "positions"}])
def test_guard_refuses_a_robot_that_needs_none(driver: dict[str, str], path: Path) -> None:
    with pytest.raises(BackendError, match="no driver of robot 'rail' has 'form: positions'"):
        Guard(robot(**driver), path)


def test_guard_refuses_a_robot_without_drivers(path: Path) -> None:
    document = robot().model_copy(update={"drivers": {}})
    with pytest.raises(BackendError, match="robot 'rail' has no drivers; its document declares"):
        Guard(document, path)

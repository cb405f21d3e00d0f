"""Goals of a controller's actions, as commanders beside its topic."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

pytest.importorskip("cyclonedds")

from cbdsl.extend.driver import FaultSample
from cbdsl_drive.survey import survey_problems
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.ros2_link import Ros2Link
from cbdsl_ros2.ros_node import RosNode
from tests.driven_robot import robot

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(1, 7)
ACTION = "/hand/gripper_cmd"
_PATIENCE = 5.0


class Server:
    """Server of an action that keeps some goals.

    Args:
        node: Node that it belongs to.
        action: Action.
    """

    def __init__(self, node: RosNode, action: str = ACTION) -> None:
        topic = f"{action}/_action/status"
        self._writer = node.writer(topic, msg.GoalStatusArray, lasting=True)

    def keep(self, *states: int) -> None:
        goals = [msg.GoalInfo(msg.Uuid([number] * 16)) for number in range(len(states))]
        pairs = zip(goals, states, strict=True)
        self._writer.write(msg.GoalStatusArray([msg.GoalStatus(*pair) for pair in pairs]))


@pytest.fixture
def link(node: RosNode) -> Iterator[Ros2Link]:
    document = robot(commands="/hand/commands")
    opened = Ros2Link(document, document.drivers, None)
    yield opened
    opened.close()


def problems(link: Ros2Link, count: int) -> list[str]:
    """Poll until a number of commanders is left; return them, and fail otherwise."""
    until = time.monotonic() + _PATIENCE
    while time.monotonic() < until:
        link.poll()
        texts = [problem.text for problem in survey_problems(link.survey())]
        commanders = [text for text in texts if text.startswith("another commander")]
        if len(commanders) == count:
            return commanders
        time.sleep(0.005)
    raise AssertionError(f"{commanders} instead of {count} commanders")


@pytest.mark.parametrize(
    ("state", "word"),
    [(ACCEPTED, "accepted"), (EXECUTING, "executing"), (CANCELING, "canceling")],
)
def test_goal_without_its_client_is_another_commander(
    state: int, word: str, node: RosNode, link: Ros2Link
) -> None:
    server = Server(node)
    server.keep(SUCCEEDED, state)
    (found,) = problems(link, 1)
    assert found.endswith(f": a goal of action {ACTION} is {word}")
    server.keep(SUCCEEDED, ABORTED)
    problems(link, 0)


def test_goal_that_begins_is_a_fault_once(node: RosNode, link: Ros2Link) -> None:
    server, faults = Server(node), []
    server.keep()
    until = time.monotonic() + 0.5
    began = False
    while time.monotonic() < until:
        faults += [sample for sample in link.poll() if isinstance(sample, FaultSample)]
        if not began and until - time.monotonic() < 0.3:
            server.keep(EXECUTING)
            began = True
        elif began:
            server.keep(EXECUTING, CANCELED)
        time.sleep(0.005)
    assert faults == [
        FaultSample("arm", f"another commander: a goal of action {ACTION} is executing")
    ]


def test_goal_of_an_ended_server_is_forgotten(node: RosNode, link: Ros2Link) -> None:
    servers = [Server(node), Server(node)]
    for server in servers:
        server.keep(EXECUTING)
    assert "is executing" in problems(link, 1)[0]
    del server
    servers.clear()
    problems(link, 0)


def test_goal_of_another_controller_is_no_commander(node: RosNode, link: Ros2Link) -> None:
    other, own = Server(node, "/arm/follow_joint_trajectory"), Server(node)
    other.keep(EXECUTING)
    own.keep(EXECUTING)
    (found,) = problems(link, 1)
    assert "/arm/" not in found

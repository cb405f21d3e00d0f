"""Link: messages of other participants over DDS, of any quality of service."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

pytest.importorskip("cyclonedds")

from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from cbdsl.extend.driver import FaultSample, PublishersSample, Sample, StopSample
from cbdsl_drive.survey import survey_problems
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.ros2_link import Ros2Link
from cbdsl_ros2.ros_node import RosNode
from tests.driven_robot import robot

_PATIENCE = 5.0
DOCUMENT = robot(stop="/stop")


@pytest.fixture
def opened(node: RosNode) -> Iterator[Callable[[], Ros2Link]]:
    """Return a function that opens the robot's link when a test needs it."""
    links: list[Ros2Link] = []

    def open_link() -> Ros2Link:
        links.append(Ros2Link(DOCUMENT, DOCUMENT.drivers, None))
        return links[-1]

    yield open_link
    for link in links:
        link.close()


def polled(link: Ros2Link, kind: type[Any], meanwhile: Callable[[], None] = lambda: None) -> Sample:
    """Return the first sample of a kind."""
    until = time.monotonic() + _PATIENCE
    while time.monotonic() < until:
        meanwhile()
        for sample in link.poll():
            if isinstance(sample, kind):
                return sample
        time.sleep(0.005)
    raise AssertionError(f"no {kind.__name__} came")


def test_link_hears_a_stop_that_was_pressed_before(
    node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    writer = node.writer("/stop", msg.Flag, lasting=True)
    writer.write(msg.Flag(True))
    sample = polled(opened(), StopSample)
    assert sample == StopSample("arm", True, sample.source)


def test_link_hears_a_stop_whose_publisher_keeps_nothing(
    node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    writer, link = node.writer("/stop", msg.Flag), opened()
    pressed = polled(link, StopSample, lambda: writer.write(msg.Flag(True)))
    assert pressed == StopSample("arm", True, pressed.source)


def test_link_tells_the_publishers_of_a_stop_apart(
    node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    states = {}
    writers = [node.writer("/stop", msg.Flag, lasting=True) for _ in range(2)]
    for writer, pressed in zip(writers, (True, False), strict=True):
        writer.write(msg.Flag(pressed))
    link, until = opened(), time.monotonic() + _PATIENCE
    while len(states) < 2 and time.monotonic() < until:
        states.update({s.source: s.pressed for s in link.poll() if isinstance(s, StopSample)})
    assert sorted(states.values()) == [False, True]
    # Both readers of the link name a publisher by the same number.
    release = writers[0]
    release.write(msg.Flag(False))
    while any(states.values()) and time.monotonic() < until:
        states.update({s.source: s.pressed for s in link.poll() if isinstance(s, StopSample)})
    assert list(states.values()) == [False, False]


def test_link_keeps_a_pressed_stop_among_many_messages(
    node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    pressing, other = (node.writer("/stop", msg.Flag) for _ in range(2))
    link, until = opened(), time.monotonic() + _PATIENCE
    for writer in (pressing, other):
        polled(link, StopSample, lambda writer=writer: writer.write(msg.Flag(False)))
    # Nothing is read meanwhile, as while a person answers.
    pressing.write(msg.Flag(True))
    for _ in range(200):
        other.write(msg.Flag(False))
    found = False
    while not found and time.monotonic() < until:
        found = any(isinstance(s, StopSample) and s.pressed for s in link.poll())
    assert found


def test_link_reports_the_end_of_the_last_publisher_of_a_stop(
    node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    writers, link = [node.writer("/stop", msg.Flag) for _ in range(2)], opened()
    while _peers(link) < 2:
        link.poll()
    link.poll()
    del writers[0]
    while _peers(link) > 1:
        assert not any(isinstance(sample, FaultSample) for sample in link.poll())
    assert not any(isinstance(sample, FaultSample) for sample in link.poll())
    del writers[0]
    fault = polled(link, FaultSample)
    assert fault == FaultSample("arm", "the last publisher of /stop has ended")


def refused(link: Ros2Link, role: str) -> tuple[str, ...]:
    """Return the refusals of a stream once its publisher is known."""
    until = time.monotonic() + _PATIENCE
    while time.monotonic() < until:
        endpoint = next(each for each in link.survey() if each.role == role)
        if endpoint.peers:
            return endpoint.refusals
        time.sleep(0.005)
    raise AssertionError("no publisher came")


@pytest.mark.parametrize("beside", [False, True])
def test_link_names_a_stop_that_it_cannot_hear(
    beside: bool, node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    link = opened()
    other = node.writer("/stop", msg.Flag, lasting=True) if beside else None
    if other is not None:
        other.write(msg.Flag(False))
        polled(link, StopSample)
    button = node.writer("/stop", msg.Flag, reliable=False)
    fault = polled(link, FaultSample, lambda: button.write(msg.Flag(True)))
    words = f"a publisher (process {os.getpid()}) is best effort, and has to be reliable"
    assert fault == FaultSample("arm", f"{words} at /stop")
    assert refused(link, "stop") == (words,)
    assert any(words in problem.text for problem in survey_problems(link.survey()))


def test_link_lists_the_living_publishers_of_a_stop(
    node: RosNode, opened: Callable[[], Ros2Link]
) -> None:
    writer, link = node.writer("/stop", msg.Flag, lasting=True), opened()
    writer.write(msg.Flag(False))
    sample = polled(link, StopSample)
    link.survey()
    publishers = polled(link, PublishersSample)
    process = f"process {os.getpid()}"
    assert publishers == PublishersSample("arm", {sample.source: process})


def rivals(link: Ros2Link, topic: str, count: int) -> tuple[str, ...]:
    """Return the other commanders of a topic once there are so many."""
    until, found = time.monotonic() + _PATIENCE, None
    while time.monotonic() < until:
        link.poll()
        found = next(each.rivals for each in link.survey() if each.address == topic)
        if len(found) == count:
            return found
        time.sleep(0.005)
    raise AssertionError(f"{found} instead of {count} rivals of {topic}")


@pytest.mark.parametrize("form", ["trajectory", "positions"])
@pytest.mark.parametrize("name", ["follow_joint_trajectory", "gripper_cmd"])
def test_client_of_an_action_of_the_controller_is_another_commander(
    form: str, name: str, node: RosNode
) -> None:
    document = robot(form=form, commands="/hand/commands")
    link = Ros2Link(document, document.drivers, None)

    def client(controller: str) -> DataWriter[msg.Text]:
        topic = f"rq/{controller}/{name}/_action/send_goalRequest"
        return DataWriter(node._participant, Topic(node._participant, topic, msg.Text))

    try:
        link.claim()
        rivals(link, "/hand/commands", 0)
        other = client("arm")
        own = client("hand")
        fault = polled(link, FaultSample)
        commander = f"process {os.getpid()} by action /hand/{name}"
        assert fault.cause == f"another commander writes to /hand/commands ({commander})"
        assert rivals(link, "/hand/commands", 1) == (commander,)
        del own, other
        rivals(link, "/hand/commands", 0)
    finally:
        link.close()


@pytest.mark.parametrize("form", ["trajectory", "positions"])
def test_link_names_another_commander_of_the_controller(form: str, node: RosNode) -> None:
    document = robot(form=form)
    message = msg.JointTrajectory if form == "trajectory" else msg.Float64MultiArray
    link = Ros2Link(document, document.drivers, None)
    try:
        link.claim()
        rivals(link, "/commands", 0)
        rival = node.writer("/commands", message)
        fault = polled(link, FaultSample)
        process = f"process {os.getpid()}"
        assert fault.cause == f"another commander writes to /commands ({process})"
        assert rivals(link, "/commands", 1) == (process,)
        del rival
        rivals(link, "/commands", 0)
    finally:
        link.close()


def test_link_accepts_one_watchdog_beside_itself(node: RosNode) -> None:
    document = robot(form="positions")
    link, nodes = Ros2Link(document, document.drivers, None), [node, RosNode()]
    try:
        dogs = []
        for count, dog in enumerate(nodes):
            reader = dog.reader("/commands/guarded", msg.Float64MultiArray)
            dogs.append((reader, dog.writer("/commands", msg.Float64MultiArray)))
            until = time.monotonic() + _PATIENCE
            while peers(link, "/commands/guarded") <= count and time.monotonic() < until:
                time.sleep(0.005)
            rivals(link, "/commands", count)
    finally:
        dogs.clear()
        link.close()
        nodes[1].close()


def peers(link: Ros2Link, topic: str) -> int:
    return next(each.peers for each in link.survey() if each.address == topic)


def _peers(link: Ros2Link) -> int:
    return next(each.peers for each in link.survey() if each.role == "stop")


def test_survey_names_each_stream_once(opened: Callable[[], Ros2Link]) -> None:
    roles = [endpoint.role for endpoint in opened().survey()]
    assert roles == ["states", "stop", "commands"]

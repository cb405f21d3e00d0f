"""Link to the parts of a robot that speak ROS 2."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np
from cyclonedds.qos import Qos

from cbdsl.extend.driver import (
    CameraSample,
    Command,
    DescriptionSample,
    Driver,
    Endpoint,
    FaultSample,
    ImageSample,
    JointSample,
    PublishersSample,
    RegionsSample,
    RobotDocument,
    Sample,
    Setup,
    StopSample,
    WrenchSample,
    absolute,
    horizon,
)
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.driver import guarded
from cbdsl_ros2.goals import Goals, client_action
from cbdsl_ros2.qos_match import mismatch
from cbdsl_ros2.regions_text import read_regions
from cbdsl_ros2.ros_node import Remote, RosNode
from cbdsl_ros2.stage_requests import StageAsker

# Messages per poll.
_MOST = 64
_FORMS = {"trajectory": msg.JointTrajectory, "positions": msg.Float64MultiArray}


@dataclass
class _Input:
    """Stream that a driver reads."""

    driver: str
    role: str
    topic: str
    message: type[Any]
    convert: Callable[[Any], Sample]
    readers: tuple[Any, ...]
    requested: Qos
    since: float = field(default_factory=time.monotonic)
    count: int = 0
    newest: float | None = None
    peers: frozenset[Any] = frozenset()


@dataclass
class _Output:
    """Stream of references to a driver's controller.

    A stream that is ours has a writer once the robot is claimed. Behind it, a watchdog that reads
    ``source`` writes the other one.
    """

    driver: str
    topic: str
    message: type[Any]
    horizon: float
    source: str | None = None
    writer: Any = None
    peers: frozenset[Any] = frozenset()
    rivals: frozenset[Any] = frozenset()

    @property
    def controller(self) -> str:
        """Namespace of the controller, which has actions beside the topic."""
        return self.topic.rpartition("/")[0]


class Ros2Link:
    """Topics of a robot's drivers of kind ``ros2``; see ``DriverLink``.

    Args:
        robot: Robot with drivers.
        drivers: Drivers of this kind, by name.
        interface: Network interface; loopback only if ``None``.

    Raises:
        BackendError: The interface cannot be used.
    """

    def __init__(
        self, robot: RobotDocument, drivers: Mapping[str, Driver], interface: str | None
    ) -> None:
        self._node = RosNode(interface)
        self._inputs = [
            _Input(name, role, topic, message, convert, readers, readers[0].get_qos())
            for name, driver in drivers.items()
            for role, topic, message, convert, qualities in _streams(name, driver)
            for readers in [tuple(self._node.reader(topic, message, **q) for q in qualities)]
        ]
        self._asker = StageAsker(self._node)
        # A survey leaves no news of peers, so the next poll has to look for changes.
        self._has_surveyed = False
        self._processes: dict[Any, str] = {}
        self._outputs: list[_Output] = []
        for name, driver in drivers.items():
            if driver.commands is not None:
                topic, message = absolute(driver.commands), _FORMS[driver.form]
                reach = horizon(driver, robot.control.rate)
                if driver.form == "positions":
                    # Without a watchdog nothing listens, and the robot is never ready.
                    source = guarded(topic)
                    self._outputs.append(_Output(name, source, message, reach))
                    self._outputs.append(_Output(name, topic, message, reach, source))
                else:
                    self._outputs.append(_Output(name, topic, message, reach))
        self._goals = Goals(self._node, (output.controller for output in self._outputs))

    def poll(self) -> Sequence[Sample]:
        """Return the samples that arrived since the last call; see ``DriverLink.poll``."""
        samples: list[Sample] = []
        for each in self._inputs:
            for message in chain.from_iterable(map(_taken, each.readers)):
                if message.sample_info.valid_data:
                    each.count, each.newest = each.count + 1, time.monotonic()
                    samples.append(each.convert(message))
        if self._node.has_news or self._has_surveyed:
            self._has_surveyed = False
            remotes = self._node.remotes()
            self._goals.look(remotes)
            samples.extend(self._changes(remotes))
        for controller, clause in self._goals.begun():
            drivers = {each.driver for each in self._outputs if each.controller == controller}
            samples.extend(FaultSample(d, f"another commander: {clause}") for d in drivers)
        return samples

    def _changes(self, remotes: Sequence[Remote]) -> Iterator[Sample]:
        """Yield the peers that ended, and commanders that began, since the last call."""
        for each in self._inputs:
            topic = absolute(each.topic)
            writers = [r for r in remotes if r.writes and r.topic == topic]
            peers = frozenset(writer.key for writer in writers)
            # A camera that ends leaves the robot on its memory, and its own time-out follows.
            if each.peers - peers and each.role in ("states", "wrenches"):
                yield FaultSample(each.driver, f"a publisher of {topic} has ended")
            if each.role == "stop":
                yield from self._buttons(each, writers)
            each.peers = peers
        for output in self._outputs:
            topic = output.topic
            peers = frozenset(r.key for r in remotes if not r.writes and r.topic == topic)
            rivals = self._rivals(output, remotes)
            if output.peers - peers:
                # A watchdog ends after a hold of its own.
                guards = any(other.source == topic for other in self._outputs)
                what = "the watchdog, which prints its cause," if guards else "a subscriber"
                yield FaultSample(output.driver, f"{what} of {topic} has ended")
            if new := rivals.keys() - output.rivals:
                names = ", ".join(sorted(self._commander(rivals[key]) for key in new))
                yield FaultSample(output.driver, f"another commander writes to {topic} ({names})")
            output.peers, output.rivals = peers, frozenset(rivals)

    def _buttons(self, each: _Input, writers: Sequence[Remote]) -> Iterator[Sample]:
        """Yield the living publishers of an emergency stop, and each that cannot be heard."""
        topic, processes = absolute(each.topic), dict[int, str]()
        # A person may press the stop by a tool that ends after its message.
        if each.peers and not writers:
            yield FaultSample(each.driver, f"the last publisher of {topic} has ended")
        for writer in writers:
            if not (refusal := self._refusal(each, writer)):
                processes[writer.handle] = self._process(writer)
            elif writer.key not in each.peers:
                yield FaultSample(each.driver, f"{refusal} at {topic}")
        yield PublishersSample(each.driver, processes)

    def _rivals(self, output: _Output, remotes: Sequence[Remote]) -> dict[Any, Remote]:
        """Return the writers of a stream of references that should not be there, by identifier."""
        # The node sees its own writers, too.
        own = None if output.writer is None else output.writer.get_guid()
        writers = [r for r in remotes if r.writes and r.topic == output.topic and r.key != own]
        if output.source is not None:
            # One watchdog writes: the process that reads our references.
            dogs = {r.participant for r in remotes if not r.writes and r.topic == output.source}
            dog = next((writer for writer in writers if writer.participant in dogs), None)
            writers = [writer for writer in writers if writer is not dog]
        for remote in remotes:
            client = client_action(remote)
            if client is not None and client[0] == output.controller:
                writers.append(remote)
        return {writer.key: writer for writer in writers}

    def _commander(self, remote: Remote) -> str:
        """Return the process of another commander, and its action if it sends goals."""
        client, process = client_action(remote), self._process(remote)
        return f"{process} by action {client[1]}" if client else process

    def _refusal(self, each: _Input, writer: Remote) -> str:
        """Return the reason why the readers of a stream get no message of a writer."""
        clause, own = mismatch(writer.qos, each.requested), msg.type_name(each.message)
        if msg.ros_type(writer.type) != own:
            clause = f"has the type {msg.ros_type(writer.type)} instead of {own}"
        return f"a publisher ({self._process(writer)}) {clause}" if clause else ""

    def _process(self, remote: Remote) -> str:
        if remote.key not in self._processes:
            self._processes[remote.key] = self._node.process(remote)
        return self._processes[remote.key]

    def claim(self) -> None:
        """Announce the writers of all commands; see ``DriverLink.claim``."""
        for output in self._outputs:
            if output.writer is None and output.source is None:
                output.writer = self._node.writer(
                    output.topic, output.message, deadline=output.horizon
                )

    def send(self, driver: str, command: Command) -> None:
        """Send references to a driver's controller; see ``DriverLink.send``."""
        output = next((o for o in self._outputs if o.driver == driver), None)
        if output is None:
            return
        assert output.writer is not None, "a link is claimed before it sends"
        if output.message is msg.Float64MultiArray:
            output.writer.write(msg.Float64MultiArray(data=list(command.positions)))
            return
        point = msg.JointTrajectoryPoint(
            positions=list(command.positions), time_from_start=msg.Duration.of(command.horizon)
        )
        header = msg.Header(stamp=msg.Time.of(command.stamp))
        output.writer.write(msg.JointTrajectory(header, list(command.names), [point]))

    def rest(self) -> None:
        """Send an empty message to each watchdog; see ``DriverLink.rest``."""
        for output in self._outputs:
            if output.writer is not None and output.message is msg.Float64MultiArray:
                output.writer.write(msg.Float64MultiArray(data=[]))

    @property
    def stages(self) -> bool:
        """True if a simulation behind the topics sets up stages; see ``StagingLink``."""
        self._has_surveyed = True
        return self._asker.is_heard

    def ask(self, setup: Setup) -> None:
        """Request a stage; see ``StagingLink.ask``."""
        self._asker.ask(setup)

    def answer(self) -> str | None:
        """Return the answer to the newest request; see ``StagingLink.answer``."""
        return self._asker.answer()

    def survey(self) -> Sequence[Endpoint]:
        """Return the state of each topic; see ``DriverLink.survey``."""
        remotes, self._has_surveyed = self._node.remotes(), True
        return [*self._surveyed_inputs(remotes), *self._surveyed_outputs(remotes)]

    def _surveyed_inputs(self, remotes: Sequence[Remote]) -> Iterator[Endpoint]:
        for each in self._inputs:
            peers = [r for r in remotes if r.writes and r.topic == absolute(each.topic)]
            foreign = _foreign(peers, each.message)
            reasons = (self._refusal(each, writer) for writer in peers)
            refusals, now = tuple(filter(None, reasons)), time.monotonic()
            yield Endpoint(
                each.driver, each.role, absolute(each.topic), msg.type_name(each.message),
                outgoing=False, peers=len(peers), foreign_types=foreign, refusals=refusals,
                candidates=_candidates(remotes, each.message, writes=True),
                rate=each.count / max(now - each.since, 1e-3),
                age=None if each.newest is None else now - each.newest,
            )  # fmt: skip

    def _surveyed_outputs(self, remotes: Sequence[Remote]) -> Iterator[Endpoint]:
        for output in self._outputs:
            peers = [r for r in remotes if not r.writes and r.topic == output.topic]
            rivals = [*map(self._commander, self._rivals(output, remotes).values())]
            rivals += self._goals.active(output.controller)
            yield Endpoint(
                output.driver, "commands", output.topic, msg.type_name(output.message),
                outgoing=True, peers=len(peers), rivals=tuple(rivals),
                foreign_types=_foreign(peers, output.message),
                candidates=_candidates(remotes, output.message, writes=False),
            )  # fmt: skip

    def close(self) -> None:
        """Leave the domain."""
        self._inputs.clear()
        self._outputs.clear()
        self._goals.close()
        del self._asker
        self._node.close()


def _foreign(peers: Sequence[Remote], message: type[Any]) -> tuple[str, ...]:
    own = msg.type_name(message)
    types = {msg.ros_type(remote.type) for remote in peers}
    return tuple(sorted(types - {own}))


def _candidates(remotes: Sequence[Remote], message: type[Any], *, writes: bool) -> tuple[str, ...]:
    """Return the topics that others write, or read, with a message type."""
    own = msg.type_name(message)
    topics = {r.topic for r in remotes if r.writes is writes and msg.ros_type(r.type) == own}
    return tuple(sorted(topics))


_Quality = dict[str, bool]
_Stream = tuple[str, str, type[Any], Callable[[Any], Sample], tuple[_Quality, ...]]


def _streams(name: str, driver: Driver) -> Iterator[_Stream]:
    """Yield role, topic, message, conversion and the readers' qualities of service."""
    usual: tuple[_Quality, ...] = ({},)
    # A lasting reader gets the state from before its time, but only from lasting writers.
    repeated = {"reliable": True, "every": True}, {"lasting": True, "every": True}
    if driver.states is not None:
        yield "states", driver.states, msg.JointState, lambda m: _joints(name, m), usual
    if driver.description is not None:
        described = lambda m: DescriptionSample(name, m.data)  # noqa: E731
        yield "description", driver.description, msg.Text, described, repeated
    if driver.stop is not None:
        pressed = lambda m: StopSample(name, bool(m.data), _source(m))  # noqa: E731
        yield "stop", driver.stop, msg.Flag, pressed, repeated
    for hand, fingers in driver.wrenches.items():
        for finger, topic in fingers.items():
            yield "wrenches", topic, msg.WrenchStamped, _wrench(name, (hand, finger)), usual
    for camera, topic in driver.images.items():
        yield "images", topic, msg.Image, _image(name, camera), usual
    for camera, topic in driver.regions.items():
        yield "regions", topic, msg.CameraRegions, _regions(name, camera), usual
    for camera, topic in driver.camera_info.items():
        yield "camera_info", topic, msg.CameraInfo, _camera(name, camera), usual


def _taken(reader: Any) -> Iterator[Any]:
    """Yield the messages of a reader, and remove them."""
    while messages := reader.take(_MOST):
        yield from messages
        if len(messages) < _MOST:
            return


def _source(message: Any) -> int:
    """Return the number of a message's publisher."""
    return int(message.sample_info.publication_handle)


def _joints(driver: str, message: msg.JointState) -> JointSample:
    return JointSample(
        driver,
        message.header.stamp.seconds,
        tuple(message.name),
        tuple(message.position),
        tuple(message.velocity),
        tuple(message.effort),
        _source(message),
    )


def _wrench(driver: str, cell: tuple[str, str]) -> Callable[[msg.WrenchStamped], Sample]:
    def convert(message: msg.WrenchStamped) -> Sample:
        force, torque = message.wrench.force, message.wrench.torque
        wrench = (force.x, force.y, force.z, torque.x, torque.y, torque.z)
        header = message.header
        return WrenchSample(driver, cell, header.stamp.seconds, header.frame_id, wrench)

    return convert


def _image(driver: str, camera: str) -> Callable[[msg.Image], Sample]:
    def convert(message: msg.Image) -> Sample:
        stamp = message.header.stamp.seconds
        return ImageSample(driver, camera, stamp, _pixels(message), message.encoding)

    return convert


def _pixels(message: msg.Image) -> np.ndarray[Any, np.dtype[np.uint8]] | None:
    """Return an RGB image, shape (height, width, 3); ``None`` if it cannot be read."""
    height, width, step = message.height, message.width, message.step
    if message.encoding not in ("rgb8", "bgr8") or step < 3 * width:
        return None
    # Rows may have padding: a step of more than 3 bytes per pixel of the width.
    if len(message.data) != height * step:
        return None
    rows = np.frombuffer(message.data, dtype=np.uint8).reshape(height, step)
    pixels = rows[:, : 3 * width].reshape(height, width, 3)
    return np.ascontiguousarray(pixels if message.encoding == "rgb8" else pixels[:, :, ::-1])


def _regions(driver: str, camera: str) -> Callable[[msg.CameraRegions], Sample]:
    def convert(message: msg.CameraRegions) -> Sample:
        stamp = message.header.stamp.seconds
        try:
            return RegionsSample(driver, camera, stamp, read_regions(message.regions))
        except ValueError as error:
            return FaultSample(
                driver, f"camera '{camera}' sends regions that cannot be read: {error}"
            )

    return convert


def _camera(driver: str, camera: str) -> Callable[[msg.CameraInfo], Sample]:
    def convert(message: msg.CameraInfo) -> Sample:
        focal = message.k[0], message.k[4]
        return CameraSample(driver, camera, message.width, message.height, focal)

    return convert

"""Server: a simulated robot behind ROS 2 topics, in real time, to test drivers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import (
    AttendedBackend,
    Backend,
    BackendError,
    Floats,
    Joints,
    Kinematics,
    Observation,
    RobotDocument,
    StageDocument,
    StagingBackend,
    embody,
    load_kept,
)
from cbdsl.extend.driver import Driver, Setup
from cbdsl_drive.links import require_drivers
from cbdsl_drive.real_time import RealTime
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.follower import Follower
from cbdsl_ros2.injected_faults import Faults
from cbdsl_ros2.regions_text import write_regions
from cbdsl_ros2.ros_node import RosNode
from cbdsl_ros2.stage_requests import StageSetter, generator

_FORMS = {"trajectory": msg.JointTrajectory, "positions": msg.Float64MultiArray}
_MOST = 64
# Ticks before an episode: two frames of a camera at a quarter of the control rate.
_WARMING = 8


class Moment(NamedTuple):
    """Robot at one time, for traces.

    Attributes:
        time: Wall time, s since the epoch.
        positions, velocities: Actuated joints, rad and rad/s, shape (n,).
        reference: References of the joints, rad, shape (n,).
    """

    time: float
    positions: Floats
    velocities: Floats
    reference: Floats


class RobotServer:
    """Simulated robot that speaks the topics of its drivers.

    Args:
        robot: Robot with drivers of kind ``ros2``.
        urdf: URDF of the robot.
        backend: Simulated robot, at the robot's control rate.
        interface: Network interface; loopback only if ``None``.
        faults: Faults that are injected.
        stage: Stage of all episodes; the requested one if ``None``.
        report: Function called with a line for each stage that is set up.

    Attributes:
        paused: Time for which the robot stood still while stages were set up, s.

    Raises:
        BackendError: The robot has no drivers of kind ``ros2``, or DDS cannot be used.
    """

    def __init__(
        self,
        robot: RobotDocument,
        urdf: Path,
        backend: Backend,
        interface: str | None = None,
        faults: Faults | None = None,
        *,
        stage: StageDocument | None = None,
        report: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._stage, self._report, self.paused = stage, report, 0.0
        self._drivers = {n: d for n, d in robot.drivers.items() if d.kind == "ros2"}
        require_drivers(robot)
        if not self._drivers:
            raise BackendError(f"robot '{robot.name}' has no drivers of kind ros2")
        self._robot, self._backend, self._faults = robot, backend, faults or Faults(())
        self._joints, self._kinematics = Joints(robot), Kinematics(robot, urdf)
        self._description = urdf.read_text(encoding="utf-8")
        self._node = RosNode(interface)
        self._writers: dict[tuple[str, ...], Any] = {}
        self._readers = {
            name: self._node.reader(driver.commands, _FORMS[driver.form], reliable=True)
            for name, driver in self._drivers.items()
            if driver.commands is not None
        }
        self._followers: dict[str, tuple[Follower, NDArray[np.intp]]] = {}
        self._setter = StageSetter(self._node, robot.name)
        self._real_time = RealTime()
        self.refused = ""

    def reset(self, stage: StageDocument, context: str | None, seed: int) -> str:
        """Set up a stage as an episode of a seed begins on it; return the context.

        The first ticks load machine code and connect writers: they precede the episode, and no
        fault acts in them.
        """
        faults, self._faults = self._faults, Faults(())
        self._set_up(stage, context, seed)
        for _ in range(_WARMING):
            self.tick()
        load_kept()
        self._faults = faults
        name = self._set_up(stage, context, seed)
        self._real_time.begin()
        return name

    def _set_up(self, stage: StageDocument, context: str | None, seed: int) -> str:
        """Begin an episode; return the context."""
        rng = np.random.default_rng([seed, 0])
        name = self._backend.reset(stage, context, rng)
        positions = self._backend.observe().positions
        for driver, section in self._drivers.items():
            joints = [j for effector in section.moves for j in self._robot.joints(effector)]
            own = self._joints.pick(joints) if joints else np.zeros(0, dtype=np.intp)
            names = tuple(section.joints.get(joint, joint) for joint in joints)
            self._followers[driver] = Follower(names, positions[own]), own
        self._reference = positions.copy()
        for driver, section in self._drivers.items():
            if section.description is not None:
                writer = self._writer((driver, "description"), section.description, msg.Text)
                writer.write(msg.Text(self._description))
        return name

    def _set_up_next(self, setup: Setup) -> None:
        """Set up the stage of the next episode around the robot.

        Raises:
            BackendError: The stage does not fit, or the backend cannot keep the robot's posture.
        """
        began = time.monotonic()
        if not isinstance(self._backend, StagingBackend):
            raise BackendError("the simulated robot's backend sets up no stage around a robot")
        stage = self._stage or setup.stage
        context = self._backend.set_up_around(stage, setup.context, generator(setup))
        load_kept()
        self._real_time.begin()
        self.paused += time.monotonic() - began
        self._report(f"set up stage {stage.name}, context {context}")

    def serve(self, watch: Callable[[Moment], bool]) -> None:
        """Run the robot in real time, until ``watch`` returns false after a control period."""
        period, due = self._backend.control_period, time.monotonic()
        while True:
            moment = self.tick()
            if not watch(moment):
                return
            # A stage is set up around a robot that nothing commands.
            if not any(f.is_commanded(time.time()) for f, _ in self._followers.values()):
                self._setter.attend(self._set_up_next)
            due += period
            left = due - time.monotonic()
            # A simulation that is slower than real time does not catch up.
            due = max(due, time.monotonic() - period)
            time.sleep(max(0.0, left))

    def tick(self) -> Moment:
        """Follow the newest commands for one control period, and publish the measurements."""
        self._faults.stall()
        backend, now = self._backend, time.time()
        self._listen(now)
        for follower, own in self._followers.values():
            # References are for the end of the tick, as ``Backend.apply`` defines.
            self._reference[own] = follower.at(now + backend.control_period)
        backend.apply(self._reference)
        backend.step()
        observation = backend.observe()
        self._publish(observation, time.time())
        return Moment(now, observation.positions, observation.velocities, self._reference.copy())

    def _listen(self, now: float) -> None:
        for name, reader in self._readers.items():
            for message in reader.take(_MOST):
                info = message.sample_info
                if not info.valid_data or self._faults.loses():
                    continue
                follower, _ = self._followers[name]
                self.refused = follower.accept(message, info.publication_handle, now)

    def _publish(self, observation: Observation, now: float) -> None:
        self._kinematics.update(observation.positions)
        for name, driver in self._drivers.items():
            self._publish_wrenches(name, driver, observation, now)
            self._publish_views(name, driver, observation, now)
            if driver.stop is not None:
                self._writer((name, "stop"), driver.stop, msg.Flag).write(msg.Flag(False))
            # Joint states come last, so that a reader that waits for them has the other messages as
            # well.
            if driver.states is not None:
                for state in self._states(name, driver, observation, now):
                    writer = self._writer((name, "states"), driver.states, msg.JointState)
                    writer.write(state)

    def _states(
        self, name: str, driver: Driver, observation: Observation, now: float
    ) -> Iterator[msg.JointState]:
        """Yield the joint states of a driver: none or one, depending on faults."""
        _, own = self._followers[name]
        indices = own if len(own) else np.arange(len(self._joints))
        names = [self._joints.names[i] for i in indices]
        state = msg.JointState(
            header=msg.Header(stamp=msg.Time.of(self._faults.stamp(now))),
            name=[driver.joints.get(joint, joint) for joint in names],
            position=observation.positions[indices].tolist(),
            velocity=observation.velocities[indices].tolist(),
            effort=[] if observation.efforts is None else observation.efforts[indices].tolist(),
        )
        yield from self._faults.states(state)

    def _publish_wrenches(
        self, name: str, driver: Driver, observation: Observation, now: float
    ) -> None:
        for hand, fingers in driver.wrenches.items():
            for finger, topic in fingers.items():
                link = self._robot.load_cells[hand][finger].link
                turn = self._kinematics.frame(link).rotation.T
                wrench = observation.loads[hand, finger]
                force, torque = (turn @ part for part in (wrench[:3], wrench[3:]))
                header = msg.Header(msg.Time.of(self._faults.stamp(now)), link)
                parts = (msg.Vector3(*part.tolist()) for part in (force, torque))
                writer = self._writer((name, hand, finger), topic, msg.WrenchStamped)
                writer.write(msg.WrenchStamped(header, msg.Wrench(*parts)))

    def _publish_views(
        self, name: str, driver: Driver, observation: Observation, now: float
    ) -> None:
        if not (observation.images or observation.regions):
            return
        exposed = observation.time if observation.exposed is None else observation.exposed
        stamp = msg.Time.of(self._faults.stamp(now - (observation.time - exposed)))
        for camera, topic in driver.images.items():
            if camera in observation.images:
                self._publish_image(name, camera, topic, observation, stamp)
        for camera, topic in driver.regions.items():
            if camera in observation.regions:
                text = write_regions(observation.regions[camera])
                message = msg.CameraRegions(
                    msg.Header(stamp, self._robot.cameras[camera].link), text
                )
                self._writer((name, camera, "regions"), topic, msg.CameraRegions).write(message)
        for camera, topic in driver.camera_info.items():
            section = self._robot.cameras[camera]
            focal, width, height = section.focal_length, section.width, section.height
            matrix = [focal, 0.0, width / 2, 0.0, focal, height / 2, 0.0, 0.0, 1.0]
            header = msg.Header(stamp, section.link)
            info = msg.CameraInfo(header, height, width, "plumb_bob", [0.0] * 5, matrix)
            self._writer((name, camera, "info"), topic, msg.CameraInfo).write(info)

    def _publish_image(
        self, name: str, camera: str, topic: str, observation: Observation, stamp: msg.Time
    ) -> None:
        image = np.ascontiguousarray(observation.images[camera])
        height, width = image.shape[:2]
        header = msg.Header(stamp, self._robot.cameras[camera].link)
        message = msg.Image(header, height, width, "rgb8", 0, 3 * width, image.tobytes())
        self._writer((name, camera, "image"), topic, msg.Image, reliable=False).write(message)

    def _writer(
        self, key: tuple[str, ...], topic: str, message: type[Any], *, reliable: bool = True
    ) -> Any:
        """Return the writer of a stream, made when it is first needed."""
        if key not in self._writers:
            lasting = key[-1] in ("description", "stop")
            self._writers[key] = self._node.writer(
                topic, message, lasting=lasting, reliable=reliable
            )
        return self._writers[key]

    def close(self) -> None:
        """Leave the domain and close the simulated robot."""
        self._writers.clear()
        self._readers.clear()
        del self._setter
        self._node.close()
        self._backend.close()
        self._real_time.end()


def simulated_robot(
    name: str, robot: RobotDocument, urdf: Path, cameras: str | None = None
) -> Backend:
    """Return a simulated robot whose ticks are as short as the robot's control periods.

    Args:
        name: Backend.
        robot: Robot to embody.
        urdf: URDF of the robot.
        cameras: ``rendered`` or ``ideal``; the backend's choice if ``None``.

    Raises:
        BackendError: The backend is unknown, or is that of a real robot.
    """
    backend = embody(name, robot, urdf, cameras=cameras)
    if isinstance(backend, AttendedBackend):
        backend.close()
        raise BackendError(f"backend '{name}' is a real robot; name a simulated one, as mujoco")
    ratio = backend.control_period * robot.control.rate
    if ratio <= 1.0 + 1e-9:
        return backend
    # The kinematic backend has fewer ticks than the robot's control rate requires.
    backend.close()
    control = robot.control.model_copy(update={"rate": robot.control.rate * ratio})
    return embody(name, robot.model_copy(update={"control": control}), urdf, cameras=cameras)

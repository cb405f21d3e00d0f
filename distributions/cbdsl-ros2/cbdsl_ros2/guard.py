"""Guard: watchdogs of a robot's forward controllers, as a separate process."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.extend.backend import Joints, read_fitting
from cbdsl.extend.driver import BackendError, Driver, RobotDocument, absolute
from cbdsl_drive.joint_limits import joint_limits
from cbdsl_drive.limiter import JointLimits
from cbdsl_drive.links import require_drivers
from cbdsl_drive.real_time import RealTime
from cbdsl_drive.watchdog import Watchdog, WatchdogPhase
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.driver import guarded
from cbdsl_ros2.ros_node import Remote, RosNode

_MOST = 64


class Guard:
    """Watchdogs between programs and a robot's forward controllers.

    Args:
        robot: Robot with drivers of kind ``ros2`` and form ``positions``.
        urdf: URDF of the robot.
        interface: Network interface; loopback only if ``None``.

    Raises:
        BackendError: No driver needs a watchdog, or DDS cannot be used.
    """

    def __init__(self, robot: RobotDocument, urdf: Path, interface: str | None = None) -> None:
        guarded_ones = {
            name: driver
            for name, driver in robot.drivers.items()
            if driver.kind == "ros2" and driver.form == "positions" and driver.commands
        }
        require_drivers(robot)
        if not guarded_ones:
            raise BackendError(
                f"no driver of robot '{robot.name}' has 'form: positions'; trajectory controllers "
                "hold still by themselves"
            )
        self.period = 1.0 / robot.control.rate
        self._node = RosNode(interface)
        # A program that finds the topics of the watchdogs relies on them immediately.
        self._real_time = RealTime()
        self._real_time.begin()
        limits, joints = joint_limits(robot, read_fitting(robot, urdf)), Joints(robot)
        self._posts = [
            _Post(name, driver, robot, joints, limits, self._node)
            for name, driver in guarded_ones.items()
        ]

    @property
    def topics(self) -> list[tuple[str, str]]:
        """Topics of input and output, by driver."""
        return [(guarded(post.topic), post.topic) for post in self._posts]

    def watch(self, report: Callable[[str], None], stopped: Callable[[], bool]) -> bool:
        """Run the watchdogs until all have stopped.

        Args:
            report: Function that takes lines for people.
            stopped: Function that returns whether a person ended the guard.

        Returns:
            True if a watchdog held.
        """
        due = time.monotonic()
        while not stopped() and any(
            post.phase is not WatchdogPhase.STOPPED for post in self._posts
        ):
            if self._node.has_news:
                remotes = self._node.remotes()
                for post in self._posts:
                    post.look(remotes, self._node)
            for post in self._posts:
                post.tick(report)
            # A late tick is not caught up by several fast ones.
            due = max(due + self.period, time.monotonic() - self.period)
            time.sleep(max(0.0, due - time.monotonic()))
        return any(
            post.phase in (WatchdogPhase.HOLDING, WatchdogPhase.STOPPED) for post in self._posts
        )

    def close(self) -> None:
        """Leave the domain."""
        self._posts.clear()
        self._node.close()
        self._real_time.end()


class _Post:
    """Watchdog of one driver, at its topics."""

    def __init__(
        self,
        name: str,
        driver: Driver,
        robot: RobotDocument,
        joints: Joints,
        limits: JointLimits,
        node: RosNode,
    ) -> None:
        assert driver.commands is not None, "checked before"
        assert driver.states is not None, "checked before"
        moved = [joint for effector in driver.moves for joint in robot.joints(effector)]
        own = joints.pick(moved)
        self.name, self.topic = name, driver.commands
        self._names = [driver.joints.get(joint, joint) for joint in moved]
        period = 1.0 / robot.control.rate
        limits = JointLimits(*(limit[own] for limit in limits))
        self._dog = Watchdog(limits, period, driver.deadline, driver.start)
        # A lost or replaced message of a program that rests would look like its death.
        self._requests = node.reader(
            guarded(driver.commands), msg.Float64MultiArray, reliable=True, every=True
        )
        self._states = node.reader(driver.states, msg.JointState)
        self._writer: Any = node.writer(driver.commands, msg.Float64MultiArray)
        self._phase, self._programs = self._dog.phase, 0

    @property
    def phase(self) -> WatchdogPhase:
        """Phase of the watchdog."""
        return self._dog.phase

    @property
    def _is_contended(self) -> bool:
        """True if several programs could begin."""
        return self.phase is WatchdogPhase.WAITING and self._programs > 1

    def look(self, remotes: Sequence[Remote], node: RosNode) -> None:
        """Hold beside another writer of the controller's topic, or a second program."""
        own, now = self._writer.get_guid(), time.monotonic()
        for topic, allowed in ((absolute(self.topic), 0), (guarded(self.topic), 1)):
            writers = [r for r in remotes if r.writes and r.topic == topic and r.key != own]
            self._programs = len(writers)
            # Before the first reference, one program may follow another.
            if len(writers) > allowed and (not allowed or self.phase is WatchdogPhase.REPEATING):
                names = ", ".join(sorted(map(node.process, writers)))
                self._dog.yield_to(f"another commander writes to {topic} ({names})", now)

    def tick(self, report: Callable[[str], None]) -> None:
        """Forward, repeat or hold, and report a new phase."""
        now = time.monotonic()
        self._measure()
        for message in self._requests.take(_MOST):
            if not message.sample_info.valid_data:
                continue
            if not len(message.data):
                self._dog.rest()
            # Another program may have come between two episodes, and neither of them begins then.
            elif len(message.data) == len(self._names) and not self._is_contended:
                self._dog.request(np.array(message.data), now)
        references = self._dog.tick(now)
        if references is not None:
            self._writer.write(msg.Float64MultiArray(data=references.tolist()))
        if self.phase is not self._phase:
            self._phase = self.phase
            cause = f": {self._dog.cause}" if self._dog.cause else ""
            report(f"driver '{self.name}' {self._phase.value}{cause}")

    def _measure(self) -> None:
        for state in self._states.take(_MOST):
            if not state.sample_info.valid_data:
                continue
            by_name = dict(zip(state.name, state.position, strict=False))
            # A robot may publish the joints of its arms in separate messages.
            if by_name.keys() >= set(self._names):
                self._dog.note_positions(np.array([by_name[name] for name in self._names]))

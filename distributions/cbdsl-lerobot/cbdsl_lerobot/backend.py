"""Backend of a robot with LeRobot's interface."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.extend.backend import (
    BackendError,
    Floats,
    Joints,
    Kinematics,
    Observation,
    RobotDocument,
    StageDocument,
    choose_context,
    read_fitting,
)
from cbdsl_lerobot.robot_interface import METHODS, LeRobot, robot_name
from cbdsl_lerobot.sensors import Sensors

# Distance beyond a limit that is an error of the encoder or of its zero, rad or m.
_ENCODER_ERROR = 0.05


class LeRobotBackend:
    """Backend of a real robot that a subclass makes; see ``Backend`` and ``LeRobot``.

    References stay within the URDF's limits of position, and change by no more than its limits of
    velocity allow. An episode begins where the robot is: a person sets up stage and posture.

    Args:
        robot: Robot document.
        urdf: URDF of the robot.
        gui: False, since a real robot has no window.
        clock: Monotonic time, s.
        sleep: Function that waits for some seconds.

    Attributes:
        patience: Longest time for an answer of the robot, and for a tick of the controllers, s.

    Raises:
        BackendError: The robot cannot be connected, lacks a sensor of the document, or is outside
            of its limits.
    """

    renderer = "the robot's cameras"
    patience = 0.2

    def __init__(
        self,
        robot: RobotDocument,
        urdf: Path,
        *,
        gui: bool = False,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if gui:
            raise BackendError("a real robot has no window; leave --gui out")
        model, self._joints = read_fitting(robot, urdf), Joints(robot).names
        self._clock, self._sleep = clock, sleep
        self.control_period = 1 / robot.control.rate
        limits = [model.joints[name] for name in self._joints]
        self._lower = np.array([limit.lower for limit in limits])
        self._upper = np.array([limit.upper for limit in limits])
        speeds = np.array([limit.velocity for limit in limits])
        speeds[np.isinf(speeds)] = robot.control.joint_speed
        self._farthest = speeds * self.control_period
        self._robot, self._connected = self.make(), True
        self._name = robot_name(self._robot)
        self._sensors = Sensors(self._name, robot, Kinematics(robot, urdf))
        self._connect()

    def make(self) -> LeRobot:
        """Return the robot, not connected yet."""
        raise BackendError(f"{type(self).__name__} has no method make, which makes the robot")

    @property
    def deadline(self) -> float | None:
        """Longest time of a tick, s; ``None`` for the first one, which loads machine code."""
        return self.patience if self._moved else None

    def _connect(self) -> None:
        """Connect the robot, and check its first observation before anything moves."""
        lacking = [name for name in METHODS if not callable(getattr(self._robot, name, None))]
        if lacking:
            raise BackendError(f"{self._name} lacks the methods {', '.join(lacking)}")
        try:
            self._call("connect")
            self._begin()
        except BackendError:
            self._leave()
            raise

    def _begin(self) -> None:
        """Take the measured posture as the reference.

        Raises:
            BackendError: It is outside of the limits.
        """
        self._moved = False
        self._sensors.begin()
        self._began = self._due = self._clock()
        self._observation = self._sense()
        at = self._observation.positions
        beyond = np.maximum(self._lower - at, at - self._upper)
        worst = int(np.argmax(beyond))
        # A larger distance suggests a wrong zero of the encoder, by which every reference would be
        # off.
        if beyond[worst] > _ENCODER_ERROR:
            raise BackendError(
                f"joint '{self._joints[worst]}' is at {at[worst]:.3g}, outside of its limits "
                f"{self._lower[worst]:.3g} to {self._upper[worst]:.3g}; calibrate the robot, or "
                "move it there by hand"
            )
        self._reference = np.clip(at, self._lower, self._upper)

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode where the robot is; see ``Backend.reset``."""
        name = choose_context(stage, context, rng)
        self._begin()
        return name

    def observe(self) -> Observation:
        """Return the newest observation."""
        return self._observation

    def apply(self, reference: Floats) -> None:
        """Set the references, rad or m, shape (n,), as far as the limits allow.

        Raises:
            BackendError: A reference is not finite.
        """
        finite = np.isfinite(reference)
        if not finite.all():
            joint = self._joints[int(np.argmin(finite))]
            raise BackendError(f"the reference of joint '{joint}' is not a finite number")
        # Changes are counted from the last reference, not from the measured position, whose lag
        # would slow the robot down.
        change = np.clip(reference - self._reference, -self._farthest, self._farthest)
        self._reference = np.clip(self._reference + change, self._lower, self._upper)

    def step(self) -> None:
        """Send the references, wait for the next control period, and read the sensors.

        Raises:
            BackendError: The robot fails, answers too late, or sends no numbers.
        """
        began = self._clock()
        self._send()
        sent = self._clock()
        # A late step is not made up for by a short one.
        self._due = max(self._due + self.control_period, sent)
        self._sleep(self._due - sent)
        woken = self._clock()
        self._observation = self._sense()
        taken = max(sent - began, self._clock() - woken)
        # Both calls are measured without the sleep in between.
        if taken > self.patience:
            raise BackendError(
                f"{self._name} took {taken:.2f} s to answer, and may take {self.patience:g} s; "
                "check its cables and other users of its bus"
            )
        self._moved = True

    def halt(self) -> None:
        """Hold the measured posture; a robot that does not take it is disconnected."""
        self._reference = np.clip(self._observation.positions, self._lower, self._upper)
        try:
            self._send()
        except BackendError:
            self._leave()
            raise

    def close(self) -> None:
        """Disconnect the robot.

        Raises:
            BackendError: It fails to disconnect.
        """
        if self._connected:
            self._connected = False
            self._call("disconnect")

    def _leave(self) -> None:
        """Disconnect after a failure, whose message takes precedence over one of this method."""
        with suppress(BackendError):
            self.close()

    def _send(self) -> None:
        pairs = zip(self._joints, self._reference.tolist(), strict=True)
        self._call("send_action", {f"{joint}.pos": value for joint, value in pairs})

    def _sense(self) -> Observation:
        values = self._call("get_observation")
        return self._sensors.read(values, self._clock() - self._began)

    def _call(self, method: str, *arguments: Any) -> Any:
        """Return the answer of the robot; drivers raise errors of any kind."""
        try:
            return getattr(self._robot, method)(*arguments)
        except Exception as error:
            fault = f"{type(error).__name__}: {error}"
            raise BackendError(f"{self._name}.{method} failed: {fault}") from error

"""A robot with the interface of LeRobot in simulated time, for tests."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.joints import Joints
from cbdsl_lerobot.backend import LeRobotBackend


class Time:
    """Clock that goes on by sleeping alone."""

    def __init__(self) -> None:
        self.now = 100.0

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now += seconds


class Device:
    """Robot that is where its last action was; everything that is done to it is noted.

    Attributes:
        values: Observation beside the joints.
        actions: Actions that were sent.
        calls: Names of the other calls.
        fail: Called before each method with its name; may raise, or let time pass.
    """

    name = "device"

    def __init__(self, robot: RobotDocument, at: float = 0.0) -> None:
        self.positions = {f"{joint}.pos": at for joint in Joints(robot).names}
        self.values: dict[str, Any] = {}
        self.actions: list[dict[str, float]] = []
        self.calls: list[str] = []
        self.fail: Callable[[str], object] = lambda method: None

    def connect(self) -> None:
        self.calls.append("connect")
        self.fail("connect")

    def get_observation(self) -> dict[str, Any]:
        self.fail("get_observation")
        return {**self.positions, **self.values}

    def send_action(self, action: dict[str, float]) -> dict[str, float]:
        self.fail("send_action")
        self.actions.append(action)
        self.positions = dict(action)
        return action

    def disconnect(self) -> None:
        self.calls.append("disconnect")
        self.fail("disconnect")


def cameras(robot: RobotDocument) -> dict[str, np.ndarray]:
    """Return a grey image of each camera."""
    return {
        name: np.full((camera.height, camera.width, 3), 128, dtype=np.uint8)
        for name, camera in robot.cameras.items()
    }


def backend_of(device: Any, robot: RobotDocument, urdf: Path, time: Time) -> LeRobotBackend:
    """Return the backend of a robot, by a subclass as packages define it."""

    class Own(LeRobotBackend):
        def make(self) -> Any:
            return device

    return Own(robot, urdf, clock=time.clock, sleep=time.sleep)

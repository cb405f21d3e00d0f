"""Six-joint arm with the interface of LeRobot, without hardware."""

import time
from typing import Any

from cbdsl_lerobot.backend import LeRobotBackend
from cbdsl_lerobot.rescaled import Rescaled, Scale

MOTORS = ("waist", "shoulder", "elbow", "forearm_roll", "wrist_bend", "flange_roll")


class Follower:
    """Motors in degrees that turn to their goals at 120 deg/s or less."""

    speed = 120.0

    def connect(self) -> None:
        self._at = dict.fromkeys(MOTORS, 0.0)
        self._goals, self._time = dict(self._at), time.monotonic()

    def _move(self) -> None:
        now = time.monotonic()
        way, self._time = self.speed * (now - self._time), now
        for motor, goal in self._goals.items():
            self._at[motor] += max(-way, min(way, goal - self._at[motor]))

    def get_observation(self) -> dict[str, Any]:
        self._move()
        return {f"{motor}.pos": angle for motor, angle in self._at.items()}

    def send_action(self, action: dict[str, float]) -> dict[str, float]:
        self._move()
        self._goals = {motor: action[f"{motor}.pos"] for motor in MOTORS}
        return action

    def disconnect(self) -> None:
        self._goals = dict(self._at)


class FollowerBackend(LeRobotBackend):
    """Six-joint arm with the interface of LeRobot, without hardware."""

    def make(self) -> Rescaled:
        return Rescaled(Follower(), {motor: Scale(motor) for motor in MOTORS})

"""A robot by rclpy: a node that plays joint_trajectory_controller with ``cmd_timeout``.

It runs under an interpreter with ``ros-jazzy-rclpy[fastrtps]``, ``ros-sensor-msgs`` and
``ros-trajectory-msgs``, and knows nothing of this project:

    python rclpy_peer.py '{"joints": {"waist": 0.1}, "rate": 60}'
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import sys
import time
from typing import Any

import rclpy
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

# Without a new trajectory for so long after the end of the last one, the controller holds.
_TIMEOUT = 0.2


class Peer:
    """Arm whose joints follow their trajectory exactly.

    Args:
        settings: ``joints`` with start positions, ``rate``, and ``urdf``.
    """

    def __init__(self, settings: dict[str, Any]) -> None:
        self._node = rclpy.create_node("peer")
        self._names, self._at = list(settings["joints"]), list(settings["joints"].values())
        self._before, self._period = list(self._at), 1.0 / settings["rate"]
        self._leg: tuple[float, float, list[float], list[float]] | None = None
        self._states = self._node.create_publisher(JointState, "/joint_states", 10)
        lasting = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        described = self._node.create_publisher(String, "/robot_description", lasting)
        described.publish(String(data=settings.get("urdf", "")))
        self._node.create_subscription(
            JointTrajectory, "/controller/joint_trajectory", self._accept, 10
        )
        self._node.create_timer(self._period, self._tick)

    def _accept(self, message: JointTrajectory) -> None:
        now, point = time.time(), message.points[-1]
        begun = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec or now
        span = point.time_from_start
        ends = begun + span.sec + 1e-9 * span.nanosec
        if ends <= now or sorted(message.joint_names) != sorted(self._names):
            return
        order = [list(message.joint_names).index(name) for name in self._names]
        self._leg = now, ends, list(self._at), [point.positions[i] for i in order]

    def _tick(self) -> None:
        now = time.time()
        if self._leg is not None:
            begun, ends, first, last = self._leg
            share = min(1.0, (now - begun) / (ends - begun))
            self._at = [a + share * (b - a) for a, b in zip(first, last, strict=True)]
            if now > ends + _TIMEOUT:
                self._leg = None
        state = JointState(name=list(self._names), position=list(self._at))
        state.header.stamp = self._node.get_clock().now().to_msg()
        moved = zip(self._at, self._before, strict=True)
        state.velocity = [(a - b) / self._period for a, b in moved]
        self._before = list(self._at)
        self._states.publish(state)

    def spin(self) -> None:
        """Run as a controller manager does: before other processes, where that is permitted."""
        gc.collect()
        gc.freeze()
        # The threads of Fast DDS receive the commands.
        for thread in os.listdir("/proc/self/task"):
            with contextlib.suppress(PermissionError, ProcessLookupError):
                os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(10))
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        rclpy.spin(self._node)


if __name__ == "__main__":
    rclpy.init()
    Peer(json.loads(sys.argv[1])).spin()

"""A robot cell by rclpy: an arm, buttons of its emergency stop, and rivals of its commander.

It runs under an interpreter with ``ros-jazzy-rclpy[fastrtps]``, ``ros-sensor-msgs`` and
``ros-trajectory-msgs``, and knows nothing of this project:

    python rclpy_cell.py arm '{"joints": {"waist": 0.1}, "rate": 60, "form": "trajectory"}'
    python rclpy_cell.py button '{"period": 0.1}'
    python rclpy_cell.py rival '{"form": "positions", "count": 6}'

Each prints ``ready``. The arm prints ``moves`` whenever it begins to move. Faults are lines of its
input: ``carry 0.8``, which moves its first joint on by so much more, rad/s, ``exchange`` and
``clock -0.3``; ``stall``, which lets it do nothing for 200 ms; ``loss`` of 30 % of its messages;
and states that are ``nan``, ``frozen`` or beyond an ``effort``, or in which joints ``swap``, are
``missing`` or ``double``. A button takes ``press``.

At SIGTERM the arm writes its motion to the file ``trace``, a line of JSON for each tick: ``[time,
positions, time of the program's newest command, time of the rival's first command]``. The last line
has the times and positions of all commands of the program.
"""

from __future__ import annotations

import contextlib
import gc
import json
import math
import os
import random
import signal
import sys
import threading
import time
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus, GoalStatusArray
from cell_motion import CellMotion
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

TOPICS = {
    "trajectory": ("/controller/joint_trajectory", JointTrajectory),
    "positions": ("/controller/commands", Float64MultiArray),
}
# Speed of an arm that moves, rad/s, and time after which it stands, s.
_MOVES, _STANDS = 0.05, 0.2
# Time without a tick after which a controller counts as stalled, s.
_STALLED = 0.1


def say(word: str) -> None:
    """Print a word immediately."""
    sys.stdout.write(f"{word}\n")
    sys.stdout.flush()


class Arm:
    """Arm whose joints follow their references exactly, with a clock of its own.

    Args:
        settings: ``joints`` with start positions, ``rate``, ``form`` and ``trace``; ``exchanged``
            if its first two joints bear each other's names.
    """

    def __init__(self, settings: dict[str, Any]) -> None:
        self._node = rclpy.create_node("arm")
        self._names, start = list(settings["joints"]), list(settings["joints"].values())
        self._motion, self._before = CellMotion(start), start
        self._period = 1.0 / settings["rate"]
        self._offset, self._speed, self._trace = 0.0, 0.0, settings["trace"]
        self._is_exchanged, self._moved = bool(settings.get("exchanged")), 0.0
        self._faults: set[str] = set()
        self._commands: list[list[float]] = []
        self._frozen: JointState | None = None
        self._rows: list[tuple[float, list[float], float, float]] = []
        self._commanded = self._rivalled = self._ticked = 0.0
        self._states = self._node.create_publisher(JointState, "/joint_states", 10)
        topic, message = TOPICS[settings["form"]]
        self._node.create_subscription(message, topic, self._accept, 100)
        self._node.create_timer(self._period, self._tick)
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in sys.stdin:
            kind, _, value = line.strip().partition(" ")
            if kind == "carry":
                recent = [row for row in self._rows if row[0] > time.time() - 0.1]
                motion = recent[-1][1][0] - recent[0][1][0]
                self._speed = motion / (recent[-1][0] - recent[0][0]) + float(value)
            elif kind == "clock":
                self._offset = float(value)
            elif kind == "exchange":
                self._is_exchanged = True
            else:
                self._faults.add(kind)

    def _now(self) -> float:
        return time.time() + self._offset

    def _accept(self, message: Any) -> None:
        now, is_array = self._now(), isinstance(message, Float64MultiArray)
        positions = message.data if is_array else message.points[-1].positions
        if any(positions):
            self._commanded = time.time()
            self._commands.append([self._commanded, *positions])
        else:
            self._rivalled = self._rivalled or time.time()
        if self._loses():
            return
        self._stop_if_stalled()
        if is_array:
            self._motion.command(positions, now, now, now + self._period)
            return
        stamp, point = message.header.stamp, message.points[-1]
        begun = stamp.sec + 1e-9 * stamp.nanosec or now
        ends = begun + point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec
        if ends <= now or sorted(message.joint_names) != sorted(self._names):
            return
        order = [list(message.joint_names).index(name) for name in self._names]
        self._motion.command([positions[i] for i in order], now, begun, ends)

    def _stop_if_stalled(self) -> None:
        """Hold still after a pause without ticks instead of catching up."""
        if self._rows and time.time() - self._ticked > _STALLED:
            self._motion.stop()

    def _tick(self) -> None:
        if "stall" in self._faults:
            self._faults.remove("stall")
            time.sleep(0.2)
        # Ticks come late on a busy computer, and speeds are by the time that passed.
        self._stop_if_stalled()
        before, self._ticked = self._ticked, time.time()
        elapsed = max(self._ticked - before, 1e-4) if self._rows else self._period
        now = self._now()
        self._motion.follow(now)
        at = list(self._motion.positions)
        if self._speed:
            # Another controller of the arm has taken its first joint over.
            at[0] = self._before[0] + self._speed * elapsed
        moved = [(a - b) / elapsed for a, b in zip(at, self._before, strict=True)]
        if max(map(abs, moved)) > _MOVES:
            if time.time() - self._moved > _STANDS:
                say("moves")
            self._moved = time.time()
        names = list(self._names)
        if self._is_exchanged:
            names[:2] = names[1::-1]
        state = JointState(name=names, position=at, velocity=moved)
        state.header.stamp.sec, rest = divmod(int(1e9 * now), 10**9)
        state.header.stamp.nanosec = rest
        self._before = at
        if not self._loses():
            self._states.publish(self._faulty(state))
        self._rows.append((time.time(), at, self._commanded, self._rivalled))

    def _loses(self) -> bool:
        return "loss" in self._faults and random.random() < 0.3

    def _faulty(self, state: JointState) -> JointState:
        """Return joint states with the faults so far."""
        if "frozen" in self._faults:
            frozen = self._frozen = self._frozen or state
            frozen.header = state.header
            return frozen
        order = list(range(len(state.name)))
        if "swap" in self._faults:
            order.reverse()
        if "missing" in self._faults:
            order.pop()
        if "double" in self._faults:
            order.append(order[0])
        positions = list(state.position)
        if "nan" in self._faults:
            positions[0] = math.nan
        faulty = JointState(header=state.header, name=[state.name[i] for i in order])
        faulty.position = [positions[i] for i in order]
        faulty.velocity = [state.velocity[i] for i in order]
        if "effort" in self._faults:
            faulty.effort = [1e6] * len(order)
        return faulty

    def close(self) -> None:
        """Write motion and commands."""
        with open(self._trace, "w") as file:
            file.writelines(json.dumps(row) + "\n" for row in [*self._rows, self._commands])


class Button:
    """Button of the emergency stop.

    Args:
        settings: ``period``, s; ``best_effort`` if it is not reliable; ``pressed``.
    """

    def __init__(self, settings: dict[str, Any]) -> None:
        kinds = ReliabilityPolicy
        reliability = kinds.BEST_EFFORT if settings.get("best_effort") else kinds.RELIABLE
        lasting = DurabilityPolicy.TRANSIENT_LOCAL if settings.get("lasting") else None
        profile = QoSProfile(depth=1, reliability=reliability)
        if lasting is not None:
            profile.durability = lasting
        self._node = rclpy.create_node("button")
        self._publisher = self._node.create_publisher(Bool, "/emergency_stop", profile)
        self._pressed = bool(settings.get("pressed"))
        self._node.create_timer(settings.get("period", 0.1), self._send)
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in sys.stdin:
            self._pressed = line.strip() == "press"

    def _send(self) -> None:
        self._publisher.publish(Bool(data=self._pressed))

    def close(self) -> None:
        """Do nothing: a button keeps nothing."""


class Goal:
    """Server of an action of the arm's controller, with a goal whose client has gone.

    Args:
        settings: None.
    """

    def __init__(self, settings: dict[str, Any]) -> None:
        profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node = rclpy.create_node("goal")
        topic = "/controller/follow_joint_trajectory/_action/status"
        publisher = self._node.create_publisher(GoalStatusArray, topic, profile)
        executing = GoalStatus(status=GoalStatus.STATUS_EXECUTING)
        publisher.publish(GoalStatusArray(status_list=[executing]))

    def close(self) -> None:
        """Do nothing: a goal keeps nothing."""


class Rival:
    """Second commander of the arm, which sends it to zero.

    Args:
        settings: ``form`` and ``joints``; ``guarded`` if it writes to the arm's watchdog.
    """

    def __init__(self, settings: dict[str, Any]) -> None:
        topic, self._message = TOPICS[settings["form"]]
        self._names = list(settings["joints"])
        topic += "/guarded" if settings.get("guarded") else ""
        self._node = rclpy.create_node("rival")
        self._publisher = self._node.create_publisher(self._message, topic, 10)
        self._node.create_timer(0.02, self._send)

    def _send(self) -> None:
        zeros = [0.0] * len(self._names)
        if self._message is Float64MultiArray:
            self._publisher.publish(Float64MultiArray(data=zeros))
            return
        point = JointTrajectoryPoint(positions=zeros)
        point.time_from_start.sec = 1
        self._publisher.publish(JointTrajectory(joint_names=self._names, points=[point]))

    def close(self) -> None:
        """Do nothing: a rival keeps nothing."""


def main() -> None:
    """Run a part of the cell until SIGTERM, before other processes where that is permitted."""
    part = {"arm": Arm, "button": Button, "goal": Goal, "rival": Rival}[sys.argv[1]](
        json.loads(sys.argv[2])
    )
    gc.collect()
    gc.freeze()
    # The threads of Fast DDS receive the commands.
    for thread in os.listdir("/proc/self/task"):
        with contextlib.suppress(PermissionError, ProcessLookupError):
            os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(10))
    say("ready")
    try:
        with contextlib.suppress(ExternalShutdownException, KeyboardInterrupt):
            rclpy.spin(part._node)
    finally:
        part.close()


if __name__ == "__main__":
    rclpy.init()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    main()

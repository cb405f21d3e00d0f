"""Node that runs programs of cbdsl as the action ``run_program`` (``cbdsl_msgs/RunProgram``).

Each goal is one episode in a process of its own, ``python -m cbdsl_ros2.run_goal``. So this node
needs nothing of cbdsl, and works on any Python of ROS. One goal runs at a time. The robot is
halted after a cancellation, after the last client of the action has gone, and with this node.

Services of actions state the identity of their requests outside of the message, in a place that
differs between the middlewares of ROS; therefore this node uses rclpy instead of DDS.
"""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import rclpy
from cbdsl_msgs.action import RunProgram
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

ACTION = "run_program"
# Period of the look at cancellation and clients, s.
_PERIOD = 0.05
# Time for the halt of a robot, s; then its process is killed, and the robot's watchdog halts it.
_HALT = 10.0


class RunProgramServer(Node):
    """Action server; its parameters are those of the launch file ``run_program.launch.py``."""

    def __init__(self) -> None:
        super().__init__("cbdsl_run_program")
        self._python = self.declare_parameter("python", sys.executable).value
        self._settings = {
            "backend": self.declare_parameter("backend", "ros2").value,
            "cameras": self.declare_parameter("cameras", "").value,
            "interface": self.declare_parameter("interface", "lo").value,
            "released": self.declare_parameter("released", False).value,
        }
        # Held while a goal runs: the executor admits goals in several threads.
        self._running = Lock()
        self._server = ActionServer(
            self,
            RunProgram,
            ACTION,
            self._run,
            goal_callback=self._admit,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def _admit(self, goal: Any) -> GoalResponse:
        if goal.program and self._running.acquire(blocking=False):
            return GoalResponse.ACCEPT
        return GoalResponse.REJECT

    def _run(self, handle: Any) -> Any:
        """Run the episode of a goal, and return the result of the action."""
        goal = handle.request
        words = {"program": goal.program, "parameters": list(goal.parameters), "seed": goal.seed}
        try:
            with self._episode(words | self._settings) as process:
                result = self._follow(handle, process)
        finally:
            self._running.release()
        self.get_logger().info(f"{goal.program}: {result.reason}")
        if handle.is_cancel_requested:
            handle.canceled()
        elif result.outcome == "success" or (result.rewarded and not result.outcome):
            handle.succeed()
        else:
            handle.abort()
        return result

    @contextmanager
    def _episode(self, goal: dict[str, Any]) -> Iterator[subprocess.Popen[str]]:
        """Start the process of an episode, and end it."""
        # The folders of ROS would hide packages of the other interpreter.
        kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        process = subprocess.Popen(
            [self._python, "-m", "cbdsl_ros2.run_goal"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=kept,
            # Ctrl-C in the terminal ends this node, which then halts the robot.
            start_new_session=True,
        )
        try:
            self._say(process, json.dumps(goal))
            yield process
        finally:
            process.stdin.close()
            try:
                process.wait(_HALT)
            except subprocess.TimeoutExpired:
                self.get_logger().error("the program did not halt in time, and was killed")
                process.kill()
                process.wait()

    def _follow(self, handle: Any, process: subprocess.Popen[str]) -> Any:
        """Publish the transitions of an episode, and return its result."""
        result = RunProgram.Result(reason="the program ended without a result")
        until = None
        for line in self._lines(process):
            reason = None if until else self._reason_to_halt(handle)
            if reason:
                until = time.monotonic() + _HALT
                self._say(process, reason)
            if until and time.monotonic() > until:
                return result
            if not line:
                continue
            row = json.loads(line)
            if "step" in row:
                handle.publish_feedback(RunProgram.Feedback(**row))
            elif "error" in row:
                result = RunProgram.Result(outcome="failure", reason=row["error"])
            else:
                result = RunProgram.Result(**row)
        return result

    def _lines(self, process: subprocess.Popen[str]) -> Iterator[str]:
        """Yield the lines of a process as they come, and empty ones in between."""
        stream = process.stdout.fileno()
        selector, kept = selectors.DefaultSelector(), b""
        selector.register(stream, selectors.EVENT_READ)
        with selector:
            while True:
                if selector.select(_PERIOD):
                    data = os.read(stream, 65536)
                    if not data:
                        return
                    *lines, kept = (kept + data).split(b"\n")
                    yield from (line.decode() for line in lines)
                yield ""

    def _reason_to_halt(self, handle: Any) -> str | None:
        if handle.is_cancel_requested:
            return "the goal was cancelled"
        if not rclpy.ok():
            return "the action server has ended"
        if not self.count_clients(f"{ACTION}/_action/send_goal"):
            return "the last client of the action has gone"
        return None

    @staticmethod
    def _say(process: subprocess.Popen[str], text: str) -> None:
        try:
            process.stdin.write(text + "\n")
            process.stdin.flush()
        except BrokenPipeError:
            pass  # it has ended, and its output has the reason


def main() -> None:
    """Serve the action until the node is shut down."""
    rclpy.init()
    executor = MultiThreadedExecutor()
    node = RunProgramServer()
    try:
        rclpy.spin(node, executor)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
        node.destroy_node()


if __name__ == "__main__":
    main()

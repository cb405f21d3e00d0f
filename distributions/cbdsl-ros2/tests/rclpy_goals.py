"""Client of the action ``run_program`` by rclpy, which prints messages as lines of JSON.

    python rclpy_goals.py GOAL [--cancel STEPS]

GOAL is JSON with the fields of the goal; ``--cancel`` cancels it after this number of feedback
messages.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from cbdsl_msgs.action import RunProgram
from rclpy.action import ActionClient

STATUSES = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_ABORTED: "aborted",
    GoalStatus.STATUS_CANCELED: "canceled",
}


def say(row: dict[str, Any]) -> None:
    """Print a row immediately."""
    sys.stdout.write(json.dumps(row) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Send the goal, and print its feedback and its result."""
    parser = argparse.ArgumentParser()
    parser.add_argument("goal", type=json.loads)
    parser.add_argument("--cancel", type=int, default=0)
    given = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node("goals")
    client = ActionClient(node, RunProgram, "run_program")
    if not client.wait_for_server(timeout_sec=30):
        sys.exit("there is no server")
    told: list[Any] = []

    def tell(message: Any) -> None:
        told.append(message.feedback)
        last = told[-1]
        say({"step": last.step, "state": last.state, "time": last.time})

    sent = client.send_goal_async(RunProgram.Goal(**given.goal), tell)
    rclpy.spin_until_future_complete(node, sent, timeout_sec=30)
    handle = sent.result()
    if not handle.accepted:
        say({"status": "rejected"})
        return
    say({"status": "accepted"})
    ended = handle.get_result_async()
    while not ended.done():
        rclpy.spin_once(node, timeout_sec=0.1)
        if given.cancel and len(told) >= given.cancel:
            given.cancel = 0
            handle.cancel_goal_async()
    result = ended.result().result
    say(
        {
            "status": STATUSES[ended.result().status],
            "outcome": result.outcome,
            "reason": result.reason,
            "rewarded": result.rewarded,
        }
    )


if __name__ == "__main__":
    main()

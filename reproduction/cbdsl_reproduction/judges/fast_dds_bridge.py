"""Bridge of topics between two domains, as a node of rclpy with Fast DDS.

A program in the second domain meets only nodes of rclpy, although the robot in the first one is
served by another DDS. The interpreter has ``ros-jazzy-rclpy[fastrtps]`` and needs nothing of this
project; ``make rclpy`` installs it:

    python fast_dds_bridge.py '{"domains": [1, 2], "out": [["/joint_states",
    "sensor_msgs/JointState", "reliable"]], "back": []}'

A topic is ``reliable``, ``lasting`` (transient local as well) or ``sensor`` (best effort).
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import sys
import threading
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy

_DEPTH, _PRIORITY = 10, 10


def _quality(kind: str) -> Any:
    """Return the quality of service of a kind of topic."""
    quality = QoSProfile(depth=1 if kind == "lasting" else _DEPTH)
    if kind == "sensor":
        quality.reliability = QoSReliabilityPolicy.BEST_EFFORT
    if kind == "lasting":
        quality.durability = QoSDurabilityPolicy.TRANSIENT_LOCAL
    return quality


def _relay(source: Any, target: Any, topic: str, message: str, kind: str) -> None:
    """Forward a topic's messages, as bytes, from one node to the other."""
    package, name = message.split("/")
    type_ = getattr(importlib.import_module(f"{package}.msg"), name)
    publisher = target.create_publisher(type_, topic, _quality(kind))
    source.create_subscription(type_, topic, publisher.publish, _quality(kind), raw=True)


def _precede_other_processes() -> None:
    """Raise the priority of all threads, those of Fast DDS included, where that is permitted."""
    for thread in os.listdir("/proc/self/task"):
        with contextlib.suppress(PermissionError, ProcessLookupError):
            os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(_PRIORITY))


def main() -> None:
    """Forward topics until a signal ends the process."""
    settings = json.loads(sys.argv[1])
    nodes, executors = [], []
    for domain in settings["domains"]:
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        nodes.append(rclpy.create_node("bridge", context=context))
        executors.append(SingleThreadedExecutor(context=context))
        executors[-1].add_node(nodes[-1])
    for topic in settings["out"]:
        _relay(nodes[0], nodes[1], *topic)
    for topic in settings["back"]:
        _relay(nodes[1], nodes[0], *topic)
    gc.collect()
    gc.freeze()
    threading.Thread(target=executors[0].spin, daemon=True).start()
    _precede_other_processes()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    executors[1].spin()


if __name__ == "__main__":
    main()

"""Memory of a served robot, of its drivers and of a program: it does not grow with the ticks."""

from __future__ import annotations

import ctypes
import gc
import time
import tracemalloc
from collections.abc import Callable

import pytest

pytest.importorskip("cyclonedds")

from cbdsl.api.load import load
from cbdsl.api.reading.robots import read_robot, read_stage
from cbdsl.backends.backend import embody
from cbdsl.extend.driver import Command
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl_drive.views import with_views
from cbdsl_ros2.dds_types import JointState
from cbdsl_ros2.ros2_link import Ros2Link
from cbdsl_ros2.ros_node import RosNode
from cbdsl_ros2.topic_server import RobotServer, simulated_robot

pytestmark = pytest.mark.slow
# Growth that is no leak, bytes: caches of interpreters, and the history of an open search.
_NOISE = 20_000


def growth(work: Callable[[int], None], count: int) -> int:
    """Return how much more memory Python holds after the same work once more, bytes.

    Caches fill in the first work, which does not count.
    """
    tracemalloc.start()
    try:
        work(count)
        gc.collect()
        before = tracemalloc.get_traced_memory()[0]
        work(count)
        gc.collect()
        return tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()


def test_ticks_of_a_served_robot_keep_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "98")
    robot, urdf = read_robot("dexter")
    served = RobotServer(robot, urdf, simulated_robot("kinematic", robot, urdf, "ideal"))
    viewed = with_views(robot, ideal=True)
    link = Ros2Link(viewed, viewed.drivers, None)
    link.claim()
    try:
        served.reset(read_stage("table_right", robot), None, 0)
        joints = tuple(j for e in robot.drivers["body"].moves for j in robot.joints(e))
        command = Command(joints, (0.0,) * len(joints), 0.05, time.time())
        received = 0

        def work(ticks: int) -> None:
            nonlocal received
            for _ in range(ticks):
                served.tick()
                received += len(link.poll())
                link.send("body", command)

        assert growth(work, 900) < _NOISE
        assert received > 1000
    finally:
        link.close()
        served.close()


def test_peers_that_come_and_go_keep_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "97")
    watching, peers, topics = RosNode(), 30, 40

    def work(count: int) -> None:
        for _ in range(count):
            node = RosNode()
            endpoints = [node.writer(f"/topic_{i}", JointState) for i in range(topics)]
            while len(watching.remotes()) < len(endpoints):
                time.sleep(0.001)
            endpoints.clear()
            node.close()
            while watching.remotes():
                time.sleep(0.001)

    try:
        work(peers)
        before = _allocated()
        work(peers)
        # A record of an endpoint that is gone needs 2 kB.
        assert _allocated() - before < 500 * peers * topics
    finally:
        watching.close()


class _MallInfo(ctypes.Structure):
    """Statistics of the GNU C library's allocator: ``struct mallinfo2``."""

    _fields_ = [(name, ctypes.c_size_t) for name in (
        "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks",
        "fordblks", "keepcost",
    )]  # fmt: skip


def _allocated() -> int:
    """Return the bytes that C code of this process has allocated."""
    library = ctypes.CDLL(None)
    if not hasattr(library, "mallinfo2"):
        pytest.skip("the allocator has no statistics")
    library.mallinfo2.restype = _MallInfo
    gc.collect()
    return int(library.mallinfo2().uordblks)


def test_episodes_of_a_program_keep_no_memory() -> None:
    request = load("reachtouch")
    backend = embody("kinematic", request.robot, request.urdf, cameras="ideal")
    try:
        kinematics = Kinematics(request.robot, request.urdf)
        runner = Runner(request.robot, kinematics, request.program, backend)

        def work(episodes: int) -> None:
            for seed in range(episodes):
                runner.run(request.stage, seed)

        assert growth(work, 12) < _NOISE
    finally:
        backend.close()

"""Server: robots that cannot be served are refused."""

from __future__ import annotations

import time

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from cbdsl.api.reading.robots import read_robot, read_stage
from cbdsl.backends.backend import BackendError
from cbdsl.extend.driver import Setup
from cbdsl.robot.joints import Joints
from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.ros_node import RosNode
from cbdsl_ros2.stage_requests import StageAsker
from cbdsl_ros2.topic_server import Moment, RobotServer, simulated_robot


def test_server_sets_up_a_requested_stage_once_nothing_commands_it(node: RosNode) -> None:
    robot, urdf = read_robot("dexter")
    lines: list[str] = []
    served = simulated_robot("kinematic", robot, urdf, "ideal")
    server = RobotServer(robot, urdf, served, report=lines.append)
    server.reset(read_stage(None, robot), None, 0)
    joints, asker = list(Joints(robot).names), StageAsker(node)
    writer = node.writer("/joint_trajectory_controller/joint_trajectory", msg.JointTrajectory)
    draws = np.random.default_rng([3, 0]).bit_generator.state
    setup = Setup("dexter", read_stage("table_right", robot), None, draws)
    point = msg.JointTrajectoryPoint(positions=[0.1] * len(joints))
    point.time_from_start = msg.Duration.of(0.2)
    begun, answered, positions = time.monotonic(), 0.0, []

    def exchange(moment: Moment) -> bool:
        nonlocal answered
        positions.append(moment.positions)
        elapsed = time.monotonic() - begun
        if elapsed < 1.5:
            writer.write(msg.JointTrajectory(msg.Header(), joints, [point]))
        if np.abs(moment.positions - positions[0]).max() > 0.05:
            asker.ask(setup)
        answered = answered or elapsed * (asker.answer() == "")
        return elapsed < 6.0 and (not answered or elapsed < answered + 0.3)

    server.serve(exchange)
    server.close()
    assert answered > 1.5
    assert lines == ["set up stage table_right, context in_view"]
    assert server.paused > 0.0
    assert np.abs(np.diff(positions, axis=0)).max() < 0.2
    assert np.abs(positions[-1] - positions[0]).max() > 0.1


def test_server_refuses_to_serve_a_real_robot() -> None:
    robot, urdf = read_robot("dexter")
    with pytest.raises(BackendError, match="'ros2' is a real robot; name a simulated one"):
        simulated_robot("ros2", robot, urdf)

"""Server: robots that cannot be served are refused."""

from __future__ import annotations

import pytest

pytest.importorskip("cyclonedds")

from cbdsl.api.reading.robots import read_robot
from cbdsl.backends.backend import BackendError
from cbdsl_ros2.topic_server import simulated_robot


def test_server_refuses_to_serve_a_real_robot() -> None:
    robot, urdf = read_robot("dexter")
    with pytest.raises(BackendError, match="'ros2' is a real robot; name a simulated one"):
        simulated_robot("ros2", robot, urdf)

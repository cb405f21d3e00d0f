"""Nodes of DDS for the tests of this folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from cbdsl_ros2.ros_node import RosNode


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Iterator[RosNode]:
    """Return a node in a domain that no test beside this one hears."""
    from cbdsl_ros2.ros_node import RosNode  # absent without cyclonedds

    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    monkeypatch.setenv("ROS_DOMAIN_ID", str(100 + worker))
    node = RosNode()
    yield node
    node.close()

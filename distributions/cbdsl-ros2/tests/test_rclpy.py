"""The backend against a node of rclpy, a ROS 2 of another vendor's DDS.

``CB_RCLPY`` names the interpreter of an environment with ``ros-jazzy-rclpy[fastrtps]``,
``ros-sensor-msgs`` and ``ros-trajectory-msgs``.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from fault_trials import robot

from cbdsl.documents.robot import RobotDocument

pytest.importorskip("cyclonedds")
PYTHON = os.environ.get("CB_RCLPY")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PYTHON, reason="CB_RCLPY names no interpreter with rclpy"),
]


@contextmanager
def peer(document: RobotDocument, seed: int) -> Iterator[None]:
    """Run a node of rclpy as the robot, in a posture drawn from a seed."""
    effector = document.effectors["arm"]
    start = np.array(effector.postures["aside"])
    start = start + np.random.default_rng(seed).uniform(-0.3, 0.3, len(start))
    settings = {"joints": dict(zip(effector.joints, start.tolist(), strict=True)), "rate": 60}
    script = Path(__file__).with_name("rclpy_peer.py")
    local = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "77"}
    process = subprocess.Popen(
        [str(PYTHON), str(script), json.dumps(settings)],
        env={**os.environ, **local},
        stdout=subprocess.PIPE,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        yield
    finally:
        process.kill()
        process.wait()


def reach(seed: int) -> str:
    """Run the six-axis arm's program on the node; return the last words."""
    from cbdsl.api.reading.robots import read_stage
    from cbdsl.backends.drivers.backend import DrivenBackend
    from cbdsl.backends.drivers.person import Consent
    from cbdsl.checking.program import check_program
    from cbdsl.kinematics.kinematics import Kinematics
    from cbdsl.runtime.episode import Runner
    from cbdsl.yaml_text.library import Library
    from tests.conftest import ROOT

    document, urdf = robot()
    program = check_program("sixaxis_reach", {}, Library(ROOT))
    with peer(document, seed):
        driven = DrivenBackend(document, urdf)
        driven.attend(Consent())
        try:
            runner = Runner(document, Kinematics(document, urdf), program, driven)
            return runner.run(read_stage(None, document), seed).ending
        finally:
            driven.close()


@pytest.mark.parametrize("seed", range(3))
def test_arm_reaches_by_a_node_of_rclpy(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "77")
    ending = reach(seed)
    assert "Done" in ending and "in state X11" in ending

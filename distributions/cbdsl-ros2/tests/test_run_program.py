"""Programs as goals of the action ``run_program``: its node and clients of rclpy.

``CB_RCLPY`` names the interpreter of an environment as ``make rclpy`` makes it. A served robot is
behind topics of Cyclone DDS, the action in Fast DDS.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("cyclonedds")
from cbdsl.extend.command import UsageError
from cbdsl_ros2.run_goal import run_goal
from tests.conftest import ROOT

PYTHON = os.environ.get("CB_RCLPY")
NEEDS_RCLPY = [
    pytest.mark.slow,
    pytest.mark.skipif(not PYTHON, reason="CB_RCLPY names no interpreter with rclpy"),
]
HERE = Path(__file__).parent
CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")
GOAL = {"program": "reachtouch", "parameters": [], "seed": 1}
# Time after which the process of a goal has ended, s.
HALT = 10.0
# The head turns at random, for as long as an episode may last.
ENDLESS = """\
cbdsl: 1
kind: program
name: turn
robot: dexter
stage: table_right
controllers:
  search: {potential: spring, reference: head.uniform, feedback: head, effector: head, gain: 8 /s}
actions: [search]
policy: {"*": search}
"""
Lines = Iterator[dict[str, Any]]


def goal(**other: Any) -> dict[str, Any]:
    local = {"backend": "kinematic", "cameras": "", "interface": None, "released": False}
    return {**GOAL, **local, **other}


def test_goal_runs_an_episode_and_tells_each_transition(capsys: pytest.CaptureFixture[str]) -> None:
    reader, writer = os.pipe()
    with os.fdopen(reader) as words, os.fdopen(writer, "w"):
        result = run_goal(goal(), words)
    steps = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert result["rewarded"] and result["reason"].startswith("Rewarded after")
    assert steps[-1]["state"] == "X11" and steps[-1]["time"] == pytest.approx(result["duration"])
    assert [each["time"] for each in steps] == sorted(each["time"] for each in steps)


@pytest.mark.parametrize("words", ["", "the goal was cancelled\n"])
def test_goal_ends_with_its_server_and_by_a_word(words: str) -> None:
    with pytest.raises(UsageError, match=words.strip() or "its server has ended"):
        run_goal(goal(), io.StringIO(words))


@pytest.mark.parametrize("parameter", ["arm", "=left_arm"])
def test_goal_with_a_broken_parameter_is_refused(parameter: str) -> None:
    with pytest.raises(UsageError, match="NAME=VALUE"):
        run_goal(goal(parameters=[parameter]), io.StringIO())


@pytest.fixture(scope="module")
def ros(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Environment of nodes of rclpy with the interfaces of this project."""
    out = tmp_path_factory.mktemp("interfaces") / "built"
    make = [str(PYTHON), str(HERE / "make_interfaces.py"), str(HERE.parent / "ros/cbdsl_msgs")]
    subprocess.run([*make, str(out)], check=True, capture_output=True)
    return {
        **os.environ,
        "PYTHONPATH": f"{out}:{HERE.parent / 'ros/cbdsl_ros'}",
        "LD_LIBRARY_PATH": str(out),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": "79",
    }


@contextmanager
def started(command: Sequence[str], env: dict[str, str]) -> Iterator[subprocess.Popen[str]]:
    """Start a process, and kill it in the end."""
    process = subprocess.Popen(
        command, env=env, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def server(
    env: dict[str, str], backend: str, released: str = "true"
) -> Iterator[subprocess.Popen[str]]:
    parameters = {"python": sys.executable, "backend": backend, "released": released}
    parameters |= {"cameras": "ideal"}
    words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    command = [str(PYTHON), "-m", "cbdsl_ros.run_program", "--ros-args", *words]
    with started(command, env) as process:
        yield process


@contextmanager
def client(env: dict[str, str], *words: str, **other: Any) -> Iterator[subprocess.Popen[str]]:
    text = json.dumps({**GOAL, **other})
    with started([str(PYTHON), str(HERE / "rclpy_goals.py"), text, *words], env) as process:
        yield process


def rows(process: subprocess.Popen[str]) -> Lines:
    assert process.stdout is not None
    return (json.loads(line) for line in process.stdout if line.startswith("{"))


@contextmanager
def served_dexter(env: dict[str, str], trace: Path) -> Iterator[subprocess.Popen[str]]:
    """Serve Dexter, and write its motion in the end."""
    command = [*CB, "drive", "serve", "dexter", "--backend", "kinematic", "--cameras", "ideal"]
    command += ["--trace", str(trace)]
    plain = {name: value for name, value in env.items() if not name.endswith("PATH")}
    with started(command, {**plain, "PATH": env["PATH"]}) as process:
        assert process.stdout is not None
        assert any("serving dexter" in line for line in process.stdout)
        yield process
        process.terminate()
        process.communicate(timeout=60)


class TestAction:
    """Node and clients."""

    pytestmark = NEEDS_RCLPY

    def test_goal_succeeds_with_feedback(self, ros: dict[str, str]) -> None:
        with server(ros, "kinematic"), client(ros) as process:
            *steps, last = rows(process)
        assert last["status"] == "succeeded" and last["rewarded"]
        assert any(row.get("state") == "X11" for row in steps)

    @pytest.mark.parametrize("program", ["nothing_such", "posture"])
    def test_goal_that_cannot_run_is_aborted_with_the_reason(
        self, program: str, ros: dict[str, str]
    ) -> None:
        wrong = {"parameters": ["arm=no_arm"]} if program == "posture" else {}
        with server(ros, "kinematic"), client(ros, program=program, **wrong) as process:
            *_, last = rows(process)
        assert last["status"] == "aborted" and last["reason"]

    def test_goal_on_a_real_robot_needs_its_release(
        self, ros: dict[str, str], tmp_path: Path
    ) -> None:
        served = served_dexter(ros, tmp_path / "motion.npz")
        with served, server(ros, "ros2", "false"), client(ros) as process:
            *_, last = rows(process)
        assert last["status"] == "aborted" and "'released'" in last["reason"]

    def test_second_goal_is_rejected_while_one_runs(
        self, ros: dict[str, str], tmp_path: Path
    ) -> None:
        with served_dexter(ros, tmp_path / "motion.npz"), server(ros, "ros2"), client(ros) as one:
            next(row for row in rows(one) if "step" in row)
            with client(ros) as other:
                assert [row["status"] for row in rows(other)] == ["rejected"]

    @pytest.mark.parametrize("end", ["cancel", "client", "server"])
    def test_robot_halts_after(self, end: str, ros: dict[str, str], tmp_path: Path) -> None:
        import numpy as np

        trace, program = tmp_path / "motion.npz", tmp_path / "turn.yaml"
        program.write_text(ENDLESS, "utf-8")
        with served_dexter(ros, trace), server(ros, "ros2") as node:
            words = ["--cancel", "1"] if end == "cancel" else []
            with client(ros, *words, program=str(program)) as process:
                lines = rows(process)
                next(row for row in lines if "step" in row)
                if end == "cancel":
                    *_, last = lines
                    assert last["status"] == "canceled" and "cancelled" in last["reason"]
                elif end == "server":
                    node.kill()
                # Else the end of this block kills the client.
            if end == "client":
                assert node.stdout is not None
                assert any("the last client of the action has gone" in line for line in node.stdout)
            until = time.monotonic() + HALT
            while time.monotonic() < until and not self._is_still(ros):
                time.sleep(0.5)
            time.sleep(1.0)
        motion = np.load(trace)
        last_second = motion["time"] > motion["time"][-1] - 0.8
        assert np.abs(motion["velocities"]).max() > 0.05  # it has moved
        assert np.abs(motion["velocities"][last_second]).max() < 0.02

    def _is_still(self, ros: dict[str, str]) -> bool:
        """Return whether no process of a goal runs any more."""
        found = subprocess.run(
            ["ps", "-eo", "args"], capture_output=True, text=True, check=True
        ).stdout.splitlines()
        return not any("cbdsl_ros2.run_goal" in line for line in found)

"""Programs on served robots, over DDS."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

from tests.conftest import ROOT

pytestmark = pytest.mark.slow
CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")
LATE = (sys.executable, str(Path(__file__).with_name("late_work.py")))


# Tests that run side by side do not hear each other.
_WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
DOMAIN = 70 + 2 * _WORKER


@pytest.fixture(scope="module")
def environment() -> dict[str, str]:
    return {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN)}


@contextmanager
def served(
    environment: dict[str, str], *options: str, command: tuple[str, ...] = CB
) -> Iterator[None]:
    process = subprocess.Popen(
        [*command, "drive", "serve", "dexter", *options], stdout=subprocess.PIPE, text=True,
        env=environment, cwd=ROOT,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert any("serving dexter" in line for line in process.stdout)
        yield
    finally:
        process.send_signal(signal.SIGTERM)
        assert process.wait(10) == 0


def cb(environment: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*CB, *words], env=environment, cwd=ROOT, capture_output=True, text=True)


def test_doctor_examines_a_served_robot_and_a_program_runs_on_it(
    environment: dict[str, str],
) -> None:
    ideal = ("--cameras", "ideal")
    with served(environment, "--backend", "kinematic", "--stage", "table_right", *ideal):
        time.sleep(1.0)
        doctor = cb(environment, "drive", "doctor", "dexter", *ideal)
        assert doctor.returncode == 0, doctor.stdout + doctor.stderr
        assert "ready" in doctor.stdout
        blind = cb(environment, "drive", "doctor", "dexter", "--seconds", "1")
        assert blind.returncode == 1
        assert "nothing writes to /left_camera/image_raw" in blind.stdout
        run = cb(environment, "run", "posture", "--backend", "ros2", "--yes", *ideal)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "move came to rest" in run.stdout


def test_doctor_leaves_a_running_program_alone_at_another_rate(
    environment: dict[str, str],
) -> None:
    options = ("--cameras", "ideal", "--seed", "3", "--rate", "120")
    with served(environment, "--backend", "kinematic", "--stage", "table_right", *options):
        words = ("run", "searchtrack", "--backend", "ros2", "--yes", "--episodes", "8")
        program = subprocess.Popen(
            [*CB, *words, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=environment, cwd=ROOT,
        )  # fmt: skip
        assert program.stdout is not None
        assert any(line.startswith("episode 1") for line in program.stdout)
        doctor = cb(environment, "drive", "doctor", "dexter", "--cameras", "ideal")
        _, problems = program.communicate(timeout=60)
    assert program.returncode == 0, problems
    assert "Topics" in doctor.stdout, doctor.stderr


def test_run_without_a_robot_names_each_topic(environment: dict[str, str]) -> None:
    run = cb({**environment, "ROS_DOMAIN_ID": "80"}, "run", "posture", "--backend", "ros2", "--yes")
    assert run.returncode == 2
    assert "- nothing writes to /joint_states (driver 'body', states)" in run.stderr
    assert "- nothing listens to /joint_trajectory_controller/joint_trajectory" in run.stderr


def test_run_without_a_terminal_asks_for_consent(environment: dict[str, str]) -> None:
    with served(environment, "--backend", "kinematic", "--cameras", "ideal"):
        words = ("run", "posture", "--backend", "ros2", "--cameras", "ideal")
        run = cb(environment, *words)
    assert run.returncode == 2
    assert "give --yes if the answer is yes" in run.stderr


@pytest.mark.parametrize("cameras", ["ideal", "rendered"])
@pytest.mark.parametrize(
    ("program", "stage"),
    [
        ("reachtouch", "table_right"),
        ("visualinspect", "spotted_right"),
        ("pick_and_place", "things_and_a_pad"),
    ],
)
def test_nothing_is_imported_or_loaded_while_a_robot_moves(
    program: str, stage: str, cameras: str, environment: dict[str, str], tmp_path: Path
) -> None:
    files = tmp_path / "robot", tmp_path / "program"
    robot, driving = ((*LATE, str(file)) for file in files)
    options = ("--seed", "3", "--cameras", cameras)
    with served(environment, "--backend", "mujoco", "--stage", stage, *options, command=robot):
        words = ("run", program, "--backend", "ros2", "--yes", *options)
        run = subprocess.run(
            [*driving, *words], env=environment, cwd=ROOT, capture_output=True, text=True
        )
    assert "episode with seed 3" in run.stdout, run.stdout + run.stderr
    assert [file.read_text() for file in files] == ["", ""]

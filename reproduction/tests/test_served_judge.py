"""Judge of served robots, which compares a robot behind ROS 2 with one in process."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl import UsageError
from cbdsl.api.shipped import shipped_program
from cbdsl_reproduction.judges import row_digests, served
from cbdsl_reproduction.judges.judge import BodyChoice, EpisodeVerdict

BODY = BodyChoice("mujoco", "ideal")


def verdicts(name: str, seeds: range) -> list[EpisodeVerdict]:
    (condition,) = (each for each in served.JUDGE.conditions if each.name == name)
    return list(served.JUDGE.measure(condition, BODY, seeds))


class Commands:
    """Commands whose episodes are rewarded, except for some served ones that hold the robot."""

    def __init__(self, held: set[int], unrewarded: set[int]) -> None:
        self.held, self.unrewarded, self.ran = held, unrewarded, list[list[str]]()

    def run(self, words: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        self.ran.append(words)
        first, count = (int(words[words.index(o) + 1]) for o in ("--seed", "--episodes"))
        is_served, lines, problem = "ros2" in words, list[str](), ""
        for seed in range(first, first + count):
            if is_served and seed in self.held:
                problem = f"cb: seed {seed}: the robot is held: a finger slipped"
                break
            row = {"seed": seed, "rewarded": seed not in self.unrewarded, "outcome": ""}
            lines.append(json.dumps({**row, "sim_seconds": 2.0, "ending": "touched"}))
        return subprocess.CompletedProcess(words, 0, "\n".join(lines), problem)


@contextmanager
def unserved(*_: object) -> Iterator[int]:
    yield 150


def test_served_judge_pairs_episodes_and_goes_on_after_a_hold(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    commands = Commands(held={502, 503}, unrewarded={505})
    monkeypatch.setattr(served, "_served", unserved)
    monkeypatch.setattr(served.subprocess, "run", commands.run)
    outcomes = [
        verdict.outcomes for verdict in verdicts("reachtouch, Cyclone DDS", range(500, 507))
    ]
    assert [each["rewarded"] for each in outcomes] == [True, True, False, False, True, False, True]
    assert [each["held"] for each in outcomes] == [
        False,
        False,
        True,
        True,
        *[False] * 3,
    ]
    lost = [seed for seed, each in enumerate(outcomes, 500) if each["rewarded in process only"]]
    assert lost == [502, 503]
    firsts = [words[words.index("--seed") + 1] for words in commands.ran if "ros2" in words]
    assert firsts == ["500", "503", "504"], "a held robot is served again"


@given(st.sets(st.integers(0, 30)))
def test_consecutive_seeds_are_grouped(seeds: set[int]) -> None:
    parts = list(served._consecutive(sorted(seeds)))
    assert [seed for part in parts for seed in part] == sorted(seeds)
    assert all(one.stop < other.start for one, other in pairwise(parts))


def test_bridge_without_rclpy_names_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CB_RCLPY", "no/python")
    with pytest.raises(UsageError, match="run 'make rclpy'"):
        served._bridge(shipped_program("reachtouch"), (1, 2))


def test_bridge_forwards_every_topic_of_a_robot(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("cbdsl_ros2.stage_requests", exc_type=ImportError)
    (python := tmp_path / "python").touch()
    monkeypatch.setenv("CB_RCLPY", str(python))
    request = shipped_program("reachtouch")
    settings: dict[str, Any] = json.loads(served._bridge(request, (1, 2))[-1])
    topics = {topic for topic, *_ in settings["out"] + settings["back"]}
    (driver,) = request.robot.drivers.values()
    assert {driver.states, driver.commands, driver.stop, driver.description} <= topics
    assert {t for fingers in driver.wrenches.values() for t in fingers.values()} <= topics
    assert {*driver.images.values(), *driver.camera_info.values()} <= topics


@pytest.mark.slow
@pytest.mark.parametrize("node", ["Cyclone DDS", "rclpy with Fast DDS"])
def test_served_judge_counts_episodes_of_a_served_robot(node: str) -> None:
    pytest.importorskip("cyclonedds")
    if node != "Cyclone DDS" and not os.environ.get("CB_RCLPY"):
        pytest.skip("CB_RCLPY names no interpreter with rclpy")
    outcomes = verdicts(f"reachtouch, {node}", range(500, 502))
    assert all(verdict.outcomes["rewarded"] for verdict in outcomes), outcomes


@pytest.mark.parametrize("driven", [True, False])
def test_row_depends_on_its_engine_and_if_served_on_drivers(
    monkeypatch: pytest.MonkeyPatch, driven: bool
) -> None:
    pytest.importorskip("cbdsl_ros2")
    pytest.importorskip("cbdsl_mujoco")
    files: list[str] = []
    monkeypatch.setattr(
        row_digests, "_files", lambda found: files.extend(map(Path.as_posix, found)) or "0"
    )
    row_digests._code.cache_clear()
    row_digests._world.__wrapped__("mujoco", driven=driven)
    row_digests._code.cache_clear()
    assert any(each.endswith("mujoco/engine.py") for each in files)
    for file in ("cbdsl_drive/motion_watch.py", "cbdsl_ros2/ros2_link.py"):
        assert any(each.endswith(file) for each in files) == driven, file

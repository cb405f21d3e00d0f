"""The safety contract: a trial of each kind of fault, by the documented commands.

``CB_RCLPY`` names an interpreter with rclpy and Fast DDS, as ``make rclpy`` makes it.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from contract_trials import CYCLONE, KINDS, STILL, Trial, attempt, selected, summary

PYTHON = os.environ.get("CB_RCLPY")


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "node", "rate"), list(selected(KINDS)))
def test_fault_holds_the_robot(kind: str, node: str, rate: float) -> None:
    if node != CYCLONE and not PYTHON:
        pytest.skip("CB_RCLPY names no interpreter with rclpy; 'make rclpy' makes one")
    outcome = attempt(kind, rate, 0, node)
    if outcome.passed:
        return
    # Beside other tests, the operating system may suspend any process of a trial for longer than
    # its deadline. Two further trials have to hold; the miss stays visible.
    further = [attempt(kind, rate, seed, node) for seed in (1, 2)]
    assert all(each.held for each in further), (outcome, further)
    late = [each for each in further if not each.passed]
    if late and all(each.time <= each.bound for each in late):
        # The document's warning CB325 says so. It is a miss, and no pass.
        pytest.xfail(f"held after {1e3 * late[0].time:.0f} ms; longest time: {1e3 * STILL:.0f} ms")
    assert not late, (outcome, further)
    pytest.xfail(f"the first of three trials missed: {outcome}")


def test_summary_counts_trials_by_node_and_rate() -> None:
    row = """{"kind": "%s", "rate": 60, "seed": 0, "moving": true, "time": %s, "way": 0.1,
    "commands": 3, "violations": 0, "cause": "", "passed": %s, "held": %s, "bound": 0.217,
    "node": "Fast DDS", "load": %s}"""
    lines = [row % ("nan", 0.05, "true", "true", 1.0), row % ("nan", 0.2, "false", "true", 3.9)]
    lines += [row % ("swap", 1, "true", "true", 0.0), row % ("nan", 0.1, "false", "false", 4.0)]
    lines.append(row % ("arm killed", "NaN", "true", "true", 0.0))
    table = summary([line.replace("\n", "") for line in lines]).splitlines()
    assert table[2].endswith("| - | - | 217 |"), "a killed arm has no time"
    assert table[3].startswith("| nan | Fast DDS | 60 | quiet | 1 of 2 | 1.3 to 98.7 % | 1 | 0 |")
    assert table[3].endswith("| 125 | 200 | 217 |")
    assert table[4].startswith("| nan | Fast DDS | 60 | busy | 0 of 1 | 0.0 to 97.5 % | 0 | 1 |")
    assert table[5].startswith("| swap | Fast DDS | 60 | quiet | 1 of 1 |")


def test_violations_count_accelerations_beyond_the_limit_after_a_pause_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    trial, period = Trial("no fault", 60.0, 0), 1.0 / 60.0
    trial._write_documents()
    # The waist accelerates by at most 0.83 rad/s in a step; the robot rests between two episodes.
    speeds = np.array([0.0, 0.0, 0.8, 1.6, 1.6, 0.8, 0.0, 0.0, -0.8, -1.6, -1.6, -0.8, 0.0])
    sent = np.zeros((len(speeds), 7))
    sent[:, 0] = period * np.arange(len(speeds)) + np.where(np.arange(len(speeds)) < 8, 0.0, 1.0)
    sent[:, 1] = period * np.cumsum(speeds)
    assert trial._violations(sent) == 0
    for tick in (4, 10):
        jump = sent.copy()
        jump[tick:, 1] += 0.03
        assert trial._violations(jump) > 0, tick

"""The safety contract: a trial of each kind of fault, by the documented commands.

``CB_RCLPY`` names an interpreter with rclpy and Fast DDS, as ``make rclpy`` makes it.
"""

from __future__ import annotations

import os

import pytest

pytest.importorskip("cyclonedds")

from contract_trials import CYCLONE, KINDS, STILL, attempt, selected, summary

pytestmark = pytest.mark.slow
PYTHON = os.environ.get("CB_RCLPY")


@pytest.mark.parametrize(("kind", "node", "rate"), list(selected(KINDS)))
def test_fault_holds_the_robot(kind: str, node: str, rate: float) -> None:
    if node != CYCLONE and not PYTHON:
        pytest.skip("CB_RCLPY names no interpreter with rclpy; 'make rclpy' makes one")
    outcome = attempt(kind, rate, 0, node)
    assert outcome.held, outcome
    if not outcome.passed and outcome.time <= outcome.bound:
        # The document's warning CB325 says so. It is a miss, and no pass.
        pytest.xfail(f"held after {1e3 * outcome.time:.0f} ms; longest time: {1e3 * STILL:.0f} ms")
    assert outcome.passed, outcome


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

"""The safety contract: a trial of each kind of fault, by the documented commands.

``CB_RCLPY`` names an interpreter with rclpy and Fast DDS, as ``make rclpy`` makes it.
"""

from __future__ import annotations

import os

import pytest

pytest.importorskip("cyclonedds")

from contract_trials import CYCLONE, KINDS, attempt, selected, summary

pytestmark = pytest.mark.slow
PYTHON = os.environ.get("CB_RCLPY")


@pytest.mark.parametrize(("kind", "node", "rate"), list(selected(KINDS)))
def test_fault_holds_the_robot(kind: str, node: str, rate: float) -> None:
    if node != CYCLONE and not PYTHON:
        pytest.skip("CB_RCLPY names no interpreter with rclpy; 'make rclpy' makes one")
    outcome = attempt(kind, rate, 0, node)
    assert outcome.passed, outcome


def test_summary_counts_trials_by_node_and_rate() -> None:
    row = """{"kind": "%s", "rate": 60, "seed": 0, "moving": true, "time": %s, "way": 0.1,
    "commands": 3, "violations": 0, "cause": "", "passed": %s, "node": "Fast DDS", "load": %s}"""
    lines = [row % ("nan", 0.05, "true", 1.0), row % ("nan", 0.2, "false", 3.9)]
    lines += [row % ("swap", 1, "true", 0.0), row % ("nan", 0.1, "true", 4.0)]
    lines.append(row % ("arm killed", "NaN", "true", 0.0))
    table = summary([line.replace("\n", "") for line in lines]).splitlines()
    assert table[2].endswith("| - | - |"), "a killed arm has no time"
    assert table[3].startswith("| nan | Fast DDS | 60 | quiet | 1 of 2 | 1.3 to 98.7 % |")
    assert table[3].endswith("| 125 | 200 |")
    assert table[4].startswith("| nan | Fast DDS | 60 | busy | 1 of 1 |")
    assert table[5].startswith("| swap | Fast DDS | 60 | quiet | 1 of 1 |")

"""Judge of first causes: each injection makes a sound program, and the table counts by kind."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import cbdsl
from benchmarks.first_causes import (
    DEVELOPED,
    JUDGED,
    CauseVerdict,
    Injection,
    table,
    verdicts,
    written,
)

_ALL = [*(("developed", each) for each in DEVELOPED), *(("judged", each) for each in JUDGED)]


@pytest.mark.parametrize(
    "injection", [each for _, each in _ALL], ids=[f"{name}-{each.kind}" for name, each in _ALL]
)
def test_injection_makes_a_program_that_loads(injection: Injection, tmp_path: Path) -> None:
    program = written(injection.edits, tmp_path, injection.program)
    assert cbdsl.load(program, stage=injection.stage or None).program.name == injection.program


def test_judged_programs_are_not_those_of_the_development() -> None:
    assert {each.program for each in JUDGED}.isdisjoint(each.program for each in DEVELOPED)


def test_table_counts_failed_episodes_by_kind() -> None:
    rows = table(
        [
            CauseVerdict("slip", "slip", True, 0.1, ""),
            CauseVerdict("slip", "lost", True, 0.1, ""),
            CauseVerdict("slip", "", False, math.nan, ""),
            CauseVerdict("", "", True, math.nan, ""),
            CauseVerdict("held", "", False, math.nan, ""),
        ]
    ).splitlines()
    assert rows[2] == "| slip | 2 | 1 of 2 | 1 of 1 | lost 1 |"
    assert rows[3].startswith("| not on the list | 1 | 1 of 1 |")
    assert rows[4] == "| held | 0 | 0 of 0 |  |  |"
    assert rows[5].startswith("| all on the list, 2 kinds | 2 | 1 of 2 (1 to 99 %)")
    assert rows[6].startswith("| published, 1 kinds | 2 | 1 of 2")


def test_verdict_on_an_unseen_object_is_right() -> None:
    (injection,) = [each for each in DEVELOPED if each.kind == "never_seen"]
    (verdict,) = verdicts(injection, (0,), "kinematic")
    assert (verdict.failed, verdict.named) == (True, "never_seen")

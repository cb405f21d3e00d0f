"""Judge of first causes: each injection makes a sound program, and the table counts by kind."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import pytest
from developed_causes import DEVELOPED
from first_causes import CauseVerdict, explained, kept, on_robot, recorded, table, written
from injected_causes import Injection
from judged_causes import JUDGED

import cbdsl

_ALL = [*(("developed", each) for each in DEVELOPED), *(("judged", each) for each in JUDGED)]


@pytest.mark.parametrize(
    "injection", [each for _, each in _ALL], ids=[f"{name}-{each.title}" for name, each in _ALL]
)
def test_injection_makes_a_program_that_loads(injection: Injection, tmp_path: Path) -> None:
    program = written(injection.edits, tmp_path, injection.program)
    request = cbdsl.load(program, stage=injection.stage or None, robot=on_robot(injection))
    assert request.program.name == injection.program


def test_judged_programs_are_not_those_of_the_development() -> None:
    assert {each.program for each in JUDGED}.isdisjoint(each.program for each in DEVELOPED)


def test_judged_causes_that_are_not_listed_are_not_those_of_the_development() -> None:
    names = [{each.name for each in chosen if not each.kind} for chosen in (DEVELOPED, JUDGED)]
    assert names[0].isdisjoint(names[1])
    assert names[0]


def test_table_counts_failed_episodes_by_kind() -> None:
    rows = table(
        [
            CauseVerdict("slip", "slip", "slip", True, 0.1, "", 0.1),
            CauseVerdict("slip", "slip", "lost", True, 0.1, "", 0.1),
            CauseVerdict("slip", "slip", "", False, math.nan, "", 0.1),
            CauseVerdict("", "wind", "", True, math.nan, "", 0.1),
            CauseVerdict("held", "held", "", False, math.nan, "", 0.1),
        ]
    ).splitlines()
    assert rows[2] == "| slip | 2 | 1 of 2 | 1 of 1 | lost 1 |"
    assert rows[3].startswith("| wind | 1 | 1 of 1 |")
    assert rows[4] == "| held | 0 | 0 of 0 |  |  |"
    assert rows[5].startswith("| not on the list, 1 kinds | 1 | 1 of 1 (2 to 100 %)")
    assert rows[6].startswith("| on the list, 2 kinds | 2 | 1 of 2 (1 to 99 %)")
    assert rows[7].startswith("| published, 1 kinds | 2 | 1 of 2")


def test_verdict_on_an_unseen_object_is_right(tmp_path: Path) -> None:
    index, *_ = [place for place, each in enumerate(DEVELOPED) if each.kind == "never_seen"]
    options = argparse.Namespace(backend="kinematic", time=90.0)
    row = recorded(DEVELOPED, index, 0, options, tmp_path)
    assert [*kept(tmp_path, [index])] == [row]
    assert [*kept(tmp_path, [index + 1])] == []
    verdict = explained(DEVELOPED[index], tmp_path / row.file, row.begin)
    assert (verdict.failed, verdict.named) == (True, "never_seen")

"""Patterns of final states in actions of any number of members."""

from __future__ import annotations

from pathlib import Path

import yaml

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

LOOKING = """\
cbdsl: 1
kind: program
name: looking
robot: dexter
stage: table_right

controllers:
  home: {potential: spring, reference: right_arm.home, feedback: right_arm, effector: right_arm}
  search: {potential: spring, reference: head.ahead, feedback: head, effector: head}
  track: {potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.sat_10, effector: head}

actions: [home, search, track]

policy:
  XXX: home
  0XX: home
  1XX: search
  X0X: search
  X1X: track
  XX0: track

success: [XX1]
failure:
  XX-: out of view
limits: {reward_ends: false}
"""


def codes(folder: Path, members: int, pattern: str) -> list[str]:
    """Return codes of a program that composes controllers and ends in a pattern."""
    names = [f"c{number}" for number in range(members)]
    whole = " ◁ ".join(names)
    data = {
        "cbdsl": 1,
        "kind": "program",
        "name": "many",
        "robot": "dexter",
        "stage": "table_right",
        "controllers": {
            name: {
                "potential": "spring",
                "reference": "stereo.sat_10",
                "feedback": "right_arm.position",
                "effector": "right_arm.position",
                "gain": f"{number + 1} /s",
            }
            for number, name in enumerate(names)
        },
        "actions": [whole, *names],
        "policy": {"*" * members: whole},
        "success": [pattern],
    }
    path = folder / "many.yaml"
    path.write_text(yaml.safe_dump(data, allow_unicode=True, sort_keys=False), encoding="utf-8")
    return [each.code for each in check_document(path, session=Session(Library(ROOT)))]


def test_end_that_the_policy_never_leads_to_is_reported(tmp_path: Path) -> None:
    # While the composition runs, no member is inactive.
    assert "CB722" in codes(tmp_path, 3, "1XX")
    assert "CB722" not in codes(tmp_path, 3, "111")


def test_check_ends_for_any_number_of_members(tmp_path: Path) -> None:
    """Forty members with three predicate values each have too many states to enumerate."""
    assert "CB722" not in codes(tmp_path, 40, "1" * 40)


def test_validate_points_at_a_pattern_of_failure_that_has_a_reason(tmp_path: Path) -> None:
    path = tmp_path / "looking.yaml"
    path.write_text(LOOKING, encoding="utf-8")
    assert not check_document(path, session=Session(Library(ROOT)))
    wrong = LOOKING.replace("  XX-: out of view", "  X-: out of view")
    path.write_text(wrong, encoding="utf-8")
    (diagnostic,) = check_document(path, session=Session(Library(ROOT)))
    assert wrong.splitlines()[diagnostic.place.line - 1].startswith("  X-:")


def test_check_keeps_the_reasons_of_failures_by_pattern() -> None:
    program = check_program("survey", library=Library(ROOT))
    assert program.failure == tuple(program.reasons)
    (pattern,) = [p for p, reason in program.reasons.items() if reason == "wider than the hand"]
    assert pattern.startswith("XX*1") and set(pattern[4:]) == {"*"}

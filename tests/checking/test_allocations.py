"""Allocations: those of the type table, and a reason for each other one."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.allocations import allocations
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Allocation
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

TRACK = """\
cbdsl: 1
kind: program
name: look
robot: dexter
parameters: {feature: sat_10, camera: left}
resources: %s
controllers:
  track: {potential: spring, reference: [0 rad, 0 rad], feedback: $camera.$feature, effector: head}
actions: [track]
"""


def allocated(path: Path) -> list[Allocation]:
    return allocations(path, Session(Library(ROOT)))


def look(folder: Path, resources: str) -> Path:
    path = folder / "look.yaml"
    path.write_text(TRACK % resources, encoding="utf-8")
    return path


def test_reachtouch_fits_each_arm_with_its_own_hand() -> None:
    found = allocated(Library(ROOT).locate(ProgramDocument, "reachtouch"))
    fitting = [each for each in found if each.program is not None]
    assert sorted(tuple(each.values.values()) for each in fitting) == [
        ("left_arm", "left_hand"),
        ("reachtouch_bimanual",),
        ("right_arm", "right_hand"),
    ]
    for each in fitting[:2]:
        assert each.program is not None and not each.refusal
        assert {**each.program.parameters}.items() >= each.values.items()
        assert each.choices == {"arm": each.values["arm"]}


def test_unsuitable_allocation_has_a_reason() -> None:
    found = allocated(Library(ROOT).locate(ProgramDocument, "reachtouch"))
    reasons = {tuple(each.values.values()): each.refusal for each in found if each.refusal}
    assert reasons["left_arm", "right_hand"] == "'right_hand' is not mounted on 'left_arm'"
    assert "robot 'dexter' states no value 'gap' of 'arms'" in reasons["arms", "hands"]


def test_programs_are_listed_by_the_signal_of_their_reward() -> None:
    found = allocated(Library(ROOT).locate(ProgramDocument, "reachtouch"))
    others = {each.values["program"]: each for each in found if "program" in each.values}
    assert {name for name, each in others.items() if each.program} == {"reachtouch_bimanual"}
    assert {"tactileprobe", "bimanualtouch", "bimanualgrab"} < others.keys()
    assert others["tactileprobe"].refusal.startswith("its actions are not those of 'reachtouch'")
    assert not {"searchtrack", "posture", "reachtouch"} & others.keys()
    both = others["reachtouch_bimanual"].program
    assert both is not None and both.name == "reachtouch"


@pytest.mark.parametrize(
    ("wanted", "code"),
    [("{it: {it: program of force}}", "CB402"), ("{it: {program: program of position}}", "CB412")],
)
def test_programs_are_asked_for_by_a_reward(tmp_path: Path, wanted: str, code: str) -> None:
    with pytest.raises(DiagnosticsError) as caught:
        check_program(str(look(tmp_path, wanted)), {}, Library(ROOT))
    assert code in {each.code for each in caught.value.diagnostics}


def test_channels_are_all_those_of_the_robot(tmp_path: Path) -> None:
    found = allocated(look(tmp_path, "{what: {feature: heading channel}}"))
    assert [each.values["feature"] for each in found if each.program] == [
        *("red", "yellow", "green", "blue"),
        *(f"{kind}_{i}" for kind in ("hue", "sat", "int") for i in range(1, 11)),
        "motion",
    ]


def test_groups_are_replaced_independently(tmp_path: Path) -> None:
    program = (ROOT / "programs" / "reachtouch.yaml").read_text()
    both = "resources:\n  what: {feature: heading channel}\n  whole: {"
    path = tmp_path / "reachtouch.yaml"
    path.write_text(program.replace("resources:\n  whole: {", both), encoding="utf-8")
    found = allocated(path)
    own = [each for each in found if "program" not in each.values]
    assert len([each for each in own if each.program]) == 35 * 2
    assert len(own) == 35 * 9


def test_program_without_resources_has_itself_alone(tmp_path: Path) -> None:
    (only,) = allocated(look(tmp_path, "{}"))
    assert only.values == {} and only.program is not None


def test_more_than_can_be_checked_are_refused(tmp_path: Path) -> None:
    two = "{a: {feature: heading channel}, b: {camera: heading channel}}"
    with pytest.raises(UsageError, match="1225 allocations are more than the 500"):
        allocated(look(tmp_path, two))

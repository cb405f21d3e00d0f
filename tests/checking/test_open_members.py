"""Programs that substitute members by their reward, and a reason for each that does not fit."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.allocations import allocations
from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Allocation
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

SCHEMA = """\
cbdsl: 1
kind: schema
name: probing
program: reachtouch
policy: reachtouch
features: {place: stereo.$feature}
allocations:
  own: {arm: right_arm, hand: right_hand}
  probe: {arm: left_arm, hand: left_hand, touch: tactileprobe}
choose: [own, probe]
otherwise: [own]
"""


@pytest.fixture(scope="module")
def found() -> list[Allocation]:
    """Return all allocations of PICKANDPLACE."""
    return allocations(
        Library(ROOT).locate(ProgramDocument, "pick_and_place"), Session(Library(ROOT))
    )


def test_transfer_from_hand_to_hand_stands_in_for_the_grasp(found: list[Allocation]) -> None:
    fitting = {"_".join(each.choices.values()): each for each in found if each.program is not None}
    assert fitting.keys() == {
        "left_arm",
        "right_arm",
        "left_arm_handover",
        "right_arm_handover",
        "left_arm_bimanualtouch",
        "left_arm_take",
        "right_arm_take",
        "left_arm_take_from_side",
        "right_arm_take_from_side",
    }
    handed = fitting["left_arm_handover"]
    assert handed.values["reachtouch"] == "handover" and handed.program is not None
    (taking,) = [each for each in handed.program.actions if each.name == "reachtouch"]
    assert taking.program is not None and taking.program.name == "handover"
    # The substitute uses the same feature, and hands the object to the carrying hand.
    assert taking.program.parameters["feature"] == "red"
    assert taking.program.parameters["hand"] == "left_hand"


@pytest.mark.parametrize(
    ("arm", "program", "reason"),
    [
        ("right_arm", "bimanualtouch", "goes by right_hand.finger_forces"),
        ("left_arm", "pick_and_lift", "does not end with its rewarded signals"),
        ("left_arm", "tactileprobe", "does not go by stereo.red"),
        ("right_arm", "reachtouch", "'grasp' uses 'reachtouch' itself"),
    ],
)
def test_program_that_cannot_replace_a_member_has_a_reason(
    found: list[Allocation], arm: str, program: str, reason: str
) -> None:
    (refused,) = [
        each
        for each in found
        if (each.values.get("arm"), each.values.get("reachtouch")) == (arm, program)
    ]
    assert refused.program is None and reason in refused.refusal
    # Programs with another reward are not candidates.
    assert "searchtrack" not in {each.values.get("reachtouch") for each in found}


def test_substitutes_are_found_under_other_names(tmp_path: Path) -> None:
    """Copies of the handover under another name are substitutes as well."""
    for name in ("pick_and_place", "handover"):
        text = (ROOT / "programs" / f"{name}.yaml").read_text(encoding="utf-8")
        other = name.replace("handover", "entrust")
        path = tmp_path / "programs" / f"{other}.yaml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.replace("name: handover", "name: entrust"), encoding="utf-8")
    library = Library(tmp_path)
    path = library.locate(ProgramDocument, "pick_and_place")
    fitting = [each for each in allocations(path, Session(library)) if each.program is not None]
    assert "entrust" in {each.values.get("reachtouch") for each in fitting}


def test_only_members_can_be_exchanged(tmp_path: Path) -> None:
    text = (ROOT / "programs" / "reachtouch.yaml").read_text(encoding="utf-8")
    path = tmp_path / "reachtouch.yaml"
    for member, is_sound in (("touch", True), ("approach", False), ("feature", False)):
        opened = text.replace("whole: {program:", f"part: {{{member}:")
        path.write_text(opened, encoding="utf-8")
        if is_sound:
            check_program(path, {}, Library(ROOT))
            continue
        with pytest.raises(DiagnosticsError) as caught:
            check_program(path, {}, Library(ROOT))
        assert [each.code for each in caught.value.diagnostics] == ["CB402"]


def diagnostics(folder: Path, text: str) -> list[str]:
    path = folder / "knowledge" / "schemas" / "probing.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return [
        f"{each.code} {each.message}" for each in check_document(path, Session(Library(folder)))
    ]


def test_schema_may_exchange_members(tmp_path: Path) -> None:
    assert diagnostics(tmp_path, SCHEMA) == []


@pytest.mark.parametrize(
    ("old", "new", "diagnostic"),
    [
        ("touch: tactileprobe", "tuch: tactileprobe", "CB606"),
        ("touch: tactileprobe", "touch: tactileprob", "no valid program 'tactileprob'"),
        ("touch: tactileprobe", "touch: searchtrack", "'searchtrack' is not rewarded for spring"),
        ("touch: tactileprobe", "touch: bimanualtouch", "'bimanualtouch' uses 'reachtouch' itself"),
        ("touch: tactileprobe", "touch: tactileprobe, program: reachtouch_bimanual", "CB634"),
        ("choose", "look: {place: {program: searchtrack, with: {channel: red}}}\nchoose", "CB645"),
        ("choose", "look: {plce: {program: searchtrack}}\nchoose", "CB638"),
        ("choose", "look: {place: {program: serchtrack}}\nchoose", "CB645"),
    ],
)
def test_unsuitable_exchange_in_a_schema_is_reported(
    tmp_path: Path, old: str, new: str, diagnostic: str
) -> None:
    (only,) = diagnostics(tmp_path, SCHEMA.replace(old, new, 1))
    assert diagnostic in only

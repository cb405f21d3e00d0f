"""Side by side, each allocation has actions and predicates of its own, and nothing else acts."""

from __future__ import annotations

from cbdsl.api.shipped import shipped_file
from cbdsl.checking.assimilation import variants_of
from cbdsl.checking.session import Session
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema import Schema
from cbdsl.yaml_text.library import Library, shipped
from cbdsl_reproduction.chapter_5.side_by_side import side_by_side


def flat() -> CheckedProgram:
    library = Library(shipped())
    path = shipped_file(library, ProgramDocument, "reachtouch")
    return side_by_side(variants_of(path, Session(library), {}), Schema("", {}, {}))


def test_flat_program_has_seven_actions_and_seven_predicates() -> None:
    program = flat()
    limbs = ("right_arm", "left_arm", "reachtouch_bimanual")
    expected = [f"{member}({limb})" for limb in limbs for member in ("reach", "touch")]
    assert list(program.members) == ["searchtrack", *expected]
    assert [each.name for each in program.actions] == list(program.members)
    assert [each.allocation for each in program.actions][:3] == ["", "right_arm", "right_arm"]


def test_touch_moves_no_joint_of_the_preceding_reach() -> None:
    program = flat()
    assert program.background is None
    reach, touch = (program.primitives[f"{name}(left_arm)"] for name in ("reach", "touch"))
    arm, hand = ({j for each in p.controllers for j in each.joints} for p in (reach, touch))
    assert "home" not in [each.name for each in reach.controllers]
    # The reach shapes its hand, which the touch then moves alone.
    assert reach.controllers[0].name == "preshape"
    assert hand < arm
    assert [each.name for each in touch.controllers] == ["touch"]


def test_touch_of_the_flat_program_seeks_immediately_and_is_rewarded() -> None:
    touch = flat().primitives["touch(right_arm)"]
    seek = touch.lead.seek
    assert seek is not None
    assert seek.once is None
    assert touch.rewarded

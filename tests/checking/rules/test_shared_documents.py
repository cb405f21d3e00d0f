"""Shared controllers, which count as if the program contained them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library

LOOKS = """\
cbdsl: 1
kind: shared
name: looks
robot: dexter
parameters: {object: red, arm: right_arm, time: 4 s, rise: 12 cm, grip: watch}
controllers:
  watch(object): {potential: spring, reference: [0 rad, 0 rad], feedback: cyclopean.$object, effector: head}
  keep(arm): {potential: spring, reference: here, feedback: $arm.orientation, effector: $arm.orientation}
  kept(arm, grip): {requires: $grip, potential: spring, reference: here, feedback: $arm, effector: $arm}
  waited(arm, time): {potential: spring, reference: here, feedback: $arm, effector: $arm, quiescence: {rate: 100, window: $time}}
  rise(arm, rise): {potential: spring, reference: "here + [0 cm, 0 cm, $rise]", feedback: $arm.position, effector: $arm.position}
  retreat(arm, rise): keep($arm) ◁ rise($arm, $rise)
conditions:
  near(object): stereo.$object.x < 60 cm
"""  # noqa: E501
HEAD = "cbdsl: 1\nkind: program\nname: go\nrobot: dexter\nparameters: {arm: right_arm}\n"
CALLS = (
    HEAD
    + """\
shared: {looks: [watch, retreat, waited, near, kept]}
controllers:
  back: retreat($arm, 20 cm)
  rest: waited($arm, 2 s)
  look: watch(red)
steps:
  rest: {exits: [near(red): back], then: back}
  back: {then: end}
background: look ◁ kept(left_arm, look)
"""
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "programs/shared").mkdir(parents=True)
    (tmp_path / "programs/shared/looks.yaml").write_text(LOOKS, encoding="utf-8")
    (tmp_path / "programs/go.yaml").write_text(CALLS, encoding="utf-8")
    return tmp_path


def edited(folder: Path, name: str, before: str, after: str) -> Path:
    path = folder / "programs" / name
    text = path.read_text("utf-8")
    assert before in text
    path.write_text(text.replace(before, after, 1), encoding="utf-8")
    return folder / "programs/go.yaml"


def test_calls_are_controllers_and_conditions_with_their_arguments(folder: Path) -> None:
    program = check_program(folder / "programs/go.yaml")
    assert program.members == ("rest", "back", "near(red)")
    assert program.background is not None
    watch, kept = program.background.controllers
    assert (watch.name, watch.feedback.name) == ("look", "cyclopean.red")
    assert (kept.effector.name, kept.requires) == ("left_arm", "look")
    rest = program.primitives["rest"]
    assert rest.lead.name == "rest" and rest.lead.quiescence.window == 2
    back = program.primitives["back"]
    assert [each.name for each in back.controllers] == ["keep($arm)", "rise($arm, 20 cm)"]


def test_documents_with_calls_have_no_findings(folder: Path) -> None:
    for name in ("go.yaml", "shared/looks.yaml"):
        assert check_document(folder / "programs" / name) == []


@pytest.mark.parametrize("section", ["own", "shared"])
def test_program_with_calls_has_the_digest_of_one_that_writes_them_out(
    folder: Path, section: str
) -> None:
    triple = (
        "{potential: spring, reference: [0 rad, 0 rad], feedback: cyclopean.red, effector: head}"
    )
    entry = {"own": triple, "shared": "watch(red)"}[section]
    taken = {"own": "", "shared": "shared: {looks: [watch]}\n"}[section]
    path = folder / "programs/look.yaml"
    path.write_text(
        f"{HEAD.replace('go', 'look')}{taken}controllers: {{look: {entry}}}\nactions: [look]\n",
        encoding="utf-8",
    )
    other = folder / "programs/other.yaml"
    other.write_text(path.read_text("utf-8").replace(entry, triple).replace(taken, ""), "utf-8")
    library = Library()
    assert program_digest(path, library).sha256 == program_digest(other, library).sha256


def test_change_of_a_shared_controller_changes_the_digest_of_its_programs(folder: Path) -> None:
    path = folder / "programs/go.yaml"
    before = program_digest(path, Library()).sha256
    edited(folder, "shared/looks.yaml", "window: $time", "window: $time, tolerance: 1 deg")
    assert program_digest(path, Library()).sha256 != before


@pytest.mark.parametrize(
    ("file", "before", "after", "code", "line"),
    [
        ("shared/looks.yaml", "keep($arm) ◁", "retreat($arm, $rise) ◁", "CB405", 12),
        ("shared/looks.yaml", "keep($arm) ◁", "kepp($arm) ◁", "CB404", 12),
        ("shared/looks.yaml", "keep($arm) ◁", "keep ◁", "CB403", 12),
        ("shared/looks.yaml", "$object.x", "$objct.x", "CB402", 14),
        ("shared/looks.yaml", "feedback: cyclopean", "feedbak: cyclopean", "CB202", 7),
        ("shared/looks.yaml", ", time: 4 s", "", "CB402", 10),
        ("go.yaml", "retreat($arm, 20 cm)", "retreat($arm)", "CB403", 8),
        ("go.yaml", "watch(red)", "watch(red, blue)", "CB403", 10),
        ("go.yaml", "[watch, retreat", "[watch, retret", "CB629", 6),
        ("go.yaml", "{looks:", "{look:", "CB628", 6),
        ("go.yaml", "[watch, retreat", "[retreat", "CB404", 10),
        ("go.yaml", "2 s", "2 cm", "CB630", 9),
        ("go.yaml", "retreat($arm", "retreat(right_am", "CB501", 8),
        (
            "go.yaml",
            "shared: {looks: [watch, retreat, waited, near, kept]}",
            "shared: x",
            "CB204",
            6,
        ),
    ],
)
def test_fault_of_a_shared_controller_is_one_finding(
    folder: Path, file: str, before: str, after: str, code: str, line: int
) -> None:
    found = check_document(edited(folder, file, before, after))
    assert [each.code for each in found if each.is_error] == [code]
    assert (Path(found[0].place.file).name, found[0].place.line) == (Path(file).name, line)


@pytest.mark.parametrize(("name", "codes"), [("watch", []), ("wach", ["CB629"])])
def test_program_of_calls_alone_needs_no_controllers(
    folder: Path, name: str, codes: list[str]
) -> None:
    path = folder / "programs/go.yaml"
    steps = "steps: {look: {do: watch(red), then: end}}\n"
    path.write_text(f"{HEAD.replace('right_arm', 'head')}shared: {{looks: [{name}]}}\n{steps}")
    assert [each.code for each in check_document(path) if each.is_error] == codes


def test_edit_of_a_shared_document_reaches_programs_of_the_same_session(folder: Path) -> None:
    session, shared = Session(), folder / "programs/shared/looks.yaml"
    path = folder / "programs/go.yaml"
    session.replace(shared, shared.read_bytes())
    assert check_document(path, session) == []
    assert session.replace(shared, shared.read_bytes().replace(b"watch(object)", b"look(object)"))
    (problem,) = check_document(path, session)
    assert (problem.code, problem.place.line) == ("CB629", 6)


def test_cycle_of_shared_controllers_is_one_finding(folder: Path) -> None:
    path = edited(
        folder,
        "shared/looks.yaml",
        "conditions:",
        "  one(arm): two($arm)\n  two(arm): one($arm)\nconditions:",
    )
    (found,) = check_document(path)
    assert (found.code, found.place.line) == ("CB405", 14)


def test_shared_controller_that_is_not_called_is_a_warning(folder: Path) -> None:
    path = edited(folder, "go.yaml", "kept]", "kept, keep]")
    (found,) = check_document(path)
    assert (found.code, found.is_error, found.place.line) == ("CB701", False, 6)


@pytest.mark.parametrize("parts", ["", "conditions: {far(arm): $arm.position.x > 1 m}\n"])
def test_shared_document_without_controllers_is_valid(folder: Path, parts: str) -> None:
    path = folder / "programs/shared/few.yaml"
    values = "parameters: {arm: right_arm}\n" if parts else ""
    path.write_text(f"cbdsl: 1\nkind: shared\nname: few\nrobot: dexter\n{values}{parts}")
    assert check_document(path) == []


def test_faulty_part_of_a_shared_document_hides_no_other_fault(folder: Path) -> None:
    parts = "one(arm): watch($arm) ◁ rise($leg, 1 m)\n  two(arm): [nothing]\n  three: two($arm)\n  "
    edited(folder, "shared/looks.yaml", "watch(object)", f"{parts}watch(object)")
    path = edited(
        folder, "shared/looks.yaml", "reference: here, feedback", "reference: her, feedback"
    )
    path = path.parent / "shared/looks.yaml"
    found = [(each.code, each.place.line) for each in check_document(path) if each.is_error]
    assert found == [("CB402", 7), ("CB204", 8), ("CB402", 9), ("CB501", 11)]


@pytest.mark.parametrize("name", ["looks", "watch", "retreat", "waited", "near", "kept"])
def test_misspelt_name_in_shared_is_one_finding(folder: Path, name: str) -> None:
    line = "shared: {looks: [watch, retreat, waited, near, kept]}"
    found = check_document(edited(folder, "go.yaml", line, line.replace(name, f"{name}x")))
    (error,) = (each for each in found if each.is_error)
    assert error.code == ("CB628" if name == "looks" else "CB629")

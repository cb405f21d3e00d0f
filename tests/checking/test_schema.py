"""Schemas: they fit their programs, run as written, and can be used by other programs."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.program import check_program, examine_program
from cbdsl.checking.schema import checked_schema
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.schema import SchemaDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.decision_tree import decide
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

SCHEMA = """\
cbdsl: 1
kind: schema
name: pick
program: reachtouch
policy: reachtouch
actions: {touch: {potential: spring, in: force, out: configuration}}
features: {place: stereo.$feature, volume: stereo.$feature.volume}
allocations:
  right: {arm: right_arm, hand: right_hand}
  left: {arm: left_arm, hand: left_hand}
choose: {if: place.y > 2 cm, then: left, else: {if: volume < 2 l, then: [right, left], else: left}}
otherwise: [right, left]
reward: {if: place.x > 1.02 m, then: 0.02, else: 0.97}
"""
USING = """\
cbdsl: 1
kind: program
name: using
robot: dexter
use: {pick: {program: reachtouch, schema: pick, with: {feature: blue}}}
controllers:
  track: {potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.blue, effector: head}
actions: [pick, track]
policy: {"**": pick}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {"knowledge/schemas/pick": SCHEMA, "programs/using": USING}.items():
        path = tmp_path / f"{name}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path


def checked(folder: Path) -> CheckedProgram:
    library = Library(folder)
    loaded = library.read(library.locate(SchemaDocument, "pick"), SchemaDocument)
    session = Session(library)
    program = checked_schema(
        loaded,
        session,
        Diagnostics(),
        lambda path, with_, own: examine_program(path, with_, session, own),
    )
    assert program is not None
    return program


def test_number_of_things_is_a_condition(folder: Path) -> None:
    file = folder / "knowledge/schemas/pick.yaml"
    text = SCHEMA.replace("volume: stereo.$feature.volume", "number: count.$feature")
    file.write_text(text.replace("volume < 2 l", "number > 1"), encoding="utf-8")
    schema = checked(folder).schema
    assert schema is not None and schema.choice is not None
    assert decide(schema.choice, {"place.y": 0.0, "number": 2.0}) == ("right", "left")
    assert decide(schema.choice, {"place.y": 0.0, "number": 1.0}) == ("left",)


def test_trees_decide_by_values_in_si_units(folder: Path) -> None:
    schema = checked(folder).schema
    assert schema is not None and schema.choice is not None and schema.reward is not None
    near, thin = {"place.y": 0.01, "place.x": 1.0}, {"volume": 0.0019}
    assert decide(schema.choice, {"place.y": 0.021}) == ("left",)
    assert decide(schema.choice, near | thin) == ("right", "left")
    assert decide(schema.choice, near | {"volume": 0.0021}) == ("left",)
    assert decide(schema.reward, near) == 0.97
    assert decide(schema.reward, {"place.x": 1.03}) == 0.02


def test_features_follow_the_parameters_of_the_using_program(folder: Path) -> None:
    program = check_program(folder / "programs" / "using.yaml", {}, Library(folder))
    (pick,) = [action.program for action in program.actions if action.program is not None]
    assert pick.schema is not None
    assert [r.name for r in pick.schema.features.values()] == ["stereo.blue", "stereo.blue.volume"]
    assert {action.allocation for action in pick.actions} == {"", "right", "left"}


def test_parameter_whose_name_begins_another_is_replaced_as_a_whole(folder: Path) -> None:
    file = folder / "knowledge" / "schemas" / "pick.yaml"
    file.write_text(SCHEMA.replace("$feature.volume", "$feature_two.volume"))
    (found,) = check_document(file, Session(Library(folder), {}))
    assert (found.code, found.message) == ("CB402", "unknown parameter 'feature_two'")


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("place: stereo.$feature", "place: stereo.$featur", "CB402"),
        ("place: stereo.$feature", "place: stereoo.$feature", "CB636"),
        ("{place: stereo", "{placee: stereo", "CB638"),
    ],
)
def test_misspelled_feature_with_many_uses_is_reported_once(
    folder: Path, old: str, new: str, code: str
) -> None:
    file = folder / "knowledge" / "schemas" / "pick.yaml"
    uses = "tried: {place.x: [0, 1], place.y: [0, 1], place.z: [0, 1]}\n"
    file.write_text((SCHEMA + uses).replace(old, new))
    found = check_document(file, Session(Library(folder), {}))
    assert [each.code for each in found] == [code]


def test_digest_of_a_program_depends_on_its_schema(folder: Path) -> None:
    using, schema = folder / "programs/using.yaml", folder / "knowledge/schemas/pick.yaml"
    before = program_digest(using, Library(folder))
    assert {"reachtouch", "searchtrack_table"} <= before.policies.keys()
    schema.write_text(schema.read_text("utf-8").replace("> 2 cm", "> 3 cm"), encoding="utf-8")
    assert program_digest(using, Library(folder)).sha256 != before.sha256


def test_schema_has_no_findings_of_its_own(folder: Path) -> None:
    path = folder / "knowledge" / "schemas" / "pick.yaml"
    assert check_document(path, Session(Library(folder))) == []


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("policy: reachtouch", "policy: searchtrack", "CB626"),
        ("policy: reachtouch", "policy: reachtuch", "CB625"),
        ("hand: left_hand", "hnd: left_hand", "CB606"),
        ("2 l", "2 cm", "CB639"),
        ("out: configuration", "out: position", "CB635"),
        ("touch: {potential", "tuch: {potential", "CB613"),
        ("0.02", "1.02", "CB208"),
    ],
)
def test_unsuitable_schema_is_reported(folder: Path, old: str, new: str, code: str) -> None:
    path = folder / "knowledge" / "schemas" / "pick.yaml"
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    found = [each.code for each in check_document(path, Session(Library(folder)))]
    assert code in found, found


def test_policy_beside_a_schema_is_a_finding(folder: Path) -> None:
    path = folder / "programs" / "using.yaml"
    path.write_text(USING.replace("schema: pick", "schema: pick, policy: reachtouch"))
    (found,) = check_document(path, Session(Library(folder)))
    assert found.code == "CB649" and "remove 'reachtouch'" in found.message
    assert found.place.line == 5


def test_schema_of_a_policy_that_has_changed_is_found(tmp_path: Path) -> None:
    """Schemas report a change of one action in their policy's file, as after relearning."""
    for kind in ("schemas", "policies"):
        (tmp_path / "knowledge" / kind).mkdir(parents=True)
        own = (ROOT / "knowledge" / kind / "reachtouch.yaml").read_text(encoding="utf-8")
        (tmp_path / "knowledge" / kind / "reachtouch.yaml").write_text(own, encoding="utf-8")
    schema, policy = (
        tmp_path / "knowledge" / kind / "reachtouch.yaml" for kind in ("schemas", "policies")
    )
    assert check_document(schema, Session(Library(tmp_path))) == []
    text = policy.read_text(encoding="utf-8")
    policy.write_text(text.replace("X1-: searchtrack", "X1-: reach", 1), encoding="utf-8")
    (found,) = check_document(schema, Session(Library(tmp_path)))
    assert found.code == "CB644" and "cb learn reachtouch" in found.message
    lines = schema.read_text(encoding="utf-8").splitlines()
    assert lines[found.place.line - 1].strip().startswith("reachtouch: c46ac23")


def test_tried_ranges_name_known_components_and_are_ordered(folder: Path) -> None:
    file = folder / "knowledge/schemas/pick.yaml"
    file.write_text(SCHEMA + "tried: {place.w: [0, 1]}\n", encoding="utf-8")
    assert [each.code for each in check_document(file, Session(Library(folder)))] == ["CB638"]
    file.write_text(SCHEMA + "tried: {place.x: [1, 0]}\n", encoding="utf-8")
    (finding,) = check_document(file, Session(Library(folder)))
    assert "put the least first" in finding.message

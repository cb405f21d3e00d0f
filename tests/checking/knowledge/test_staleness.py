"""Learned documents are stale after a change of a program, policy, robot or stage."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from cbdsl import check
from cbdsl.checking.knowledge.staleness import changed_inputs
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.relations import RelationsDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT
from tests.relearn import commands, learned

CHANGES = {
    "program pick_and_place": ("programs/pick_and_place.yaml", "speed: 4 cm/s", "speed: 5 cm/s"),
    "policy pick_and_place": ("knowledge/policies/pick_and_place.yaml", "transport ◁", "place ◁"),
    "robot dexter": ("robots/dexter.yaml", "rate: 15 Hz", "rate: 14 Hz"),
    "stage things_and_far_pads": ("programs/stages/things_and_far_pads.yaml", "[", "[ 0.5, "),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("programs", "knowledge", "robots"):
        shutil.copytree(ROOT / name, tmp_path / name)
    return tmp_path


def changed(folder: Path) -> list[str]:
    path = folder / "knowledge" / "schemas" / "pick_and_place.yaml"
    library = Library(folder)
    document = library.read(path, SchemaDocument).document
    return list(changed_inputs(document, path, library))


@pytest.mark.parametrize("name", CHANGES)
def test_changed_inputs_names_a_changed_document(folder: Path, name: str) -> None:
    file, old, new = CHANGES[name]
    before = changed(folder)
    text = (folder / file).read_text("utf-8")
    assert old in text
    if name.startswith("stage"):
        text = text.replace("share: ", "share: 1", 1)
    else:
        text = text.replace(old, new, 1)
    (folder / file).write_text(text, "utf-8")
    assert name in changed(folder)
    assert name not in before


def test_changed_inputs_names_a_program_and_the_shared_document_that_changed_it(
    folder: Path,
) -> None:
    file = folder / "programs" / "shared" / "looking.yaml"
    text = file.read_text("utf-8")
    unused, used = ("tolerance: 0.1}", "tolerance: 0.2}"), ("[0 deg, 0 deg]", "[1 deg, 0 deg]")
    assert unused[0] in text and used[0] in text
    file.write_text(text.replace(*unused), "utf-8")
    assert changed(folder) == []
    file.write_text(text.replace(*used), "utf-8")
    # Others may have changed since the program was learned, without effect on it.
    program, *shared = changed(folder)
    assert program == "program pick_and_place"
    assert "shared looking" in shared and "shared moving" not in shared


def test_changed_inputs_of_relations_names_the_earlier_ones(folder: Path) -> None:
    earlier = folder / "knowledge" / "relations" / "touching.yaml"
    text = earlier.read_text("utf-8")
    earlier.write_text(text.replace("dRz > 0.05", "dRz > 0.06", 1), "utf-8")
    path, library = earlier.with_name("contacts.yaml"), Library(folder)
    document = library.read(path, RelationsDocument).document
    assert list(changed_inputs(document, path, library)) == ["relations touching"]


def test_changed_inputs_of_a_meta_catalog_names_its_relations(folder: Path) -> None:
    relations = folder / "knowledge" / "relations" / "contacts.yaml"
    text = relations.read_text("utf-8")
    relations.write_text(text.replace("dPz > 5", "dPz > 6", 1), "utf-8")
    path, library = folder / "knowledge" / "meta_catalogs" / "things_in_touch.yaml", Library(folder)
    document = library.read(path, MetaCatalogDocument).document
    assert "relations contacts" in list(changed_inputs(document, path, library))


def test_validate_of_relations_after_a_change_of_their_program_reports_cb622(folder: Path) -> None:
    program = folder / "programs" / "impedance.yaml"
    text = program.read_text("utf-8")
    program.write_text(text.replace("force: 2 N", "force: 3 N", 1), "utf-8")
    found = check(folder / "knowledge" / "relations" / "touching.yaml")
    assert [each.code for each in found] == ["CB622"]


def test_changed_inputs_without_a_provenance_says_so(folder: Path) -> None:
    path = folder / "knowledge" / "policies" / "reachtouch.yaml"
    library = Library(folder)
    document = library.read(path, PolicyDocument).document.model_copy(update={"provenance": None})
    assert list(changed_inputs(document, path, library)) == ["its provenance is missing"]


def test_commands_of_a_joined_exploration_begin_without_the_joined_programs() -> None:
    first, second = commands(learned()["catalogs/basketball_and_pad"].data)
    assert "--join" in second and "--join" not in first
    assert not any(word.startswith("pick_and_place") for word in first)
    assert first[first.index("--actions") + 1] == "100"
    assert "searchtrack" in first


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("programs/take.yaml", "speed: ", "speed: 1"),
        ("programs/handover.yaml", "speed: 25 cm/s", "speed: 24 cm/s"),
        ("programs/shared/moving.yaml", "gain: ", "gain: 1"),
    ],
)
def test_validate_and_show_knowledge_name_the_same_changed_inputs_of_a_schema(
    folder: Path, file: str, old: str, new: str
) -> None:
    text = (folder / file).read_text("utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), "utf-8")
    schema = folder / "knowledge" / "schemas" / "pick_and_place.yaml"
    lines, document = (
        schema.read_text("utf-8").splitlines(),
        Library(folder).read(schema, SchemaDocument),
    )
    own = [d for d in check(schema) if d.place.file == str(schema) and d.code in ("CB622", "CB644")]
    validated = {lines[d.place.line - 1].split(":")[0].strip() for d in own}
    provenance = document.document.provenance
    assert provenance is not None
    shown = {name.split()[1] for name in changed(folder)}
    assert shown & {*provenance.programs, *provenance.policies} == validated


def test_changed_inputs_names_a_replaced_program_that_is_gone(folder: Path) -> None:
    schema = folder / "knowledge" / "schemas" / "pick_and_place.yaml"
    schema.write_text(schema.read_text("utf-8").replace("take_from_side", "taken_away"), "utf-8")
    assert changed(folder) == ["program taken_away"]

"""Shipped catalogs belong to the programs as they are, and say what their objects afford."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.digest import program_digest
from cbdsl.checking.session import Session
from cbdsl.documents.catalog import CATALOG, CatalogDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

CATALOGS = sorted((ROOT / CATALOG.folder).glob("*.yaml"))
AFFORDED = {
    "green_table": {"searchtrack", "reachtouch"},
    "basketball": {"searchtrack", "reachtouch", "bimanualtouch"},
    "red_ball": {
        *("searchtrack", "reachtouch", "bimanualtouch"),
        *("visualinspect_blue", "visualinspect_yellow"),
    },
}


def test_all_three_are_shipped() -> None:
    assert {path.stem for path in CATALOGS} == AFFORDED.keys()


@pytest.mark.parametrize("path", CATALOGS, ids=lambda path: path.stem)
def test_it_has_no_findings_and_is_of_programs_as_they_are(path: Path) -> None:
    library = Library(ROOT)
    assert check_document(path, Session(library)) == []
    provenance = library.read(path, CatalogDocument).document.provenance
    assert provenance is not None and provenance.actions == 100
    for name, program in provenance.programs.items():
        file = library.locate(ProgramDocument, program.name)
        assert program.sha256 == program_digest(file, library).sha256, name


@pytest.mark.parametrize("path", CATALOGS, ids=lambda path: path.stem)
def test_it_says_what_its_object_affords(path: Path) -> None:
    catalog = Library(ROOT).read(path, CatalogDocument).document
    afforded = {name for name, each in catalog.affordances.items() if each.rewarded}
    assert afforded == AFFORDED[path.stem]

"""Shipped catalogs belong to the current programs, and match the source's catalogs."""

from __future__ import annotations

import itertools
import shlex
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.session import Session
from cbdsl.documents.catalog import CATALOG, CatalogDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.catalog_models import models_of
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

CATALOGS = sorted((ROOT / CATALOG.folder).glob("*.yaml"))
# Section 6.2.2: affordances found for each object; with a pad, PICKANDPLACE joined (7.1).
# The open inspection is rewarded when the mark of its turn is found.
AFFORDED = {
    # The blue pad is a second colour within the outline of the green table.
    "table_and_pad": {"searchtrack", "reachtouch", "visualinspect_blue"},
    "basketball_and_pad": {"searchtrack", "reachtouch", "bimanualtouch", "pick_and_place"},
    "red_ball_and_pad": {
        "searchtrack",
        "reachtouch",
        "bimanualtouch",
        "visualinspect",
        "visualinspect_blue",
        "visualinspect_yellow",
        "pick_and_place",
    },
    "table": {"searchtrack", "reachtouch"},
    "basketball": {"searchtrack", "reachtouch", "bimanualtouch"},
    "red_ball": {
        "searchtrack",
        "reachtouch",
        "bimanualtouch",
        "visualinspect",
        "visualinspect_blue",
        "visualinspect_yellow",
    },
}


@pytest.fixture(params=CATALOGS, ids=lambda path: path.stem)
def path(request: pytest.FixtureRequest) -> Path:
    return Path(request.param)


@pytest.fixture
def catalog(path: Path, library: Library) -> CatalogDocument:
    return library.read(path, CatalogDocument).document


def test_expected_catalogs_are_shipped() -> None:
    assert {path.stem for path in CATALOGS} == AFFORDED.keys()


def test_shipped_catalog_has_no_diagnostics(path: Path, library: Library) -> None:
    assert not check_document(path, Session(library))


def test_programs_of_a_shipped_catalog_have_their_recorded_digests(
    catalog: CatalogDocument, library: Library
) -> None:
    assert catalog.provenance is not None
    for name, identity in catalog.provenance.programs.items():
        file = library.locate(ProgramDocument, identity.name)
        assert program_digest(file, library).sha256 == identity.sha256, name


def test_rewarded_actions_of_a_shipped_catalog_are_those_of_the_source(
    catalog: CatalogDocument,
) -> None:
    rewarded = {name for name, each in catalog.affordances.items() if each.rewarded}
    assert rewarded == AFFORDED[catalog.name]
    models = models_of(catalog)
    assert all(models[name].rewarded.weight > 0 for name in rewarded)


def test_command_in_the_provenance_repeats_the_exploration(
    catalog: CatalogDocument, path: Path
) -> None:
    assert catalog.provenance is not None and catalog.steps is not None
    words = shlex.split(catalog.provenance.command)
    options = dict(itertools.pairwise(words))
    assert words[:2] == ["cb", "explore"]
    assert options["--out"] == path.name
    assert options["--stage"] == catalog.provenance.stage.name
    assert int(options["--actions"]) == catalog.provenance.actions == len(catalog.steps.action)


@pytest.mark.parametrize("name", [name for name in AFFORDED if name.endswith("_and_pad")])
def test_joined_program_is_tried_after_it_joins(name: str, library: Library) -> None:
    catalog = library.read(library.locate(CatalogDocument, name), CatalogDocument).document
    assert catalog.provenance is not None and catalog.steps is not None
    (joined,) = catalog.provenance.joined
    assert (joined.after, joined.programs) == (100, ("pick_and_place",))
    before, after = catalog.steps.action[:100], catalog.steps.action[100:]
    assert "pick_and_place" not in before
    assert after.count("pick_and_place") >= 5
    # The world that came with it changed, too: a pad is to be seen.
    known = library.read(library.locate(CatalogDocument, name[:-8]), CatalogDocument).document
    assert catalog.affordances.keys() > known.affordances.keys()

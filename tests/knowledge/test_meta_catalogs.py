"""The shipped meta-catalog belongs to the programs as they are, and has stacks to plan."""

from __future__ import annotations

import itertools
import shlex

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.session import Session
from cbdsl.documents.document_digest import digest
from cbdsl.documents.meta_catalog import META_CATALOG, MetaCatalogDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.catalogs.stack_plan import plan_stack
from cbdsl.learning.catalogs.thing_graph import support_graph
from cbdsl.program.catalog_models import pair_models
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

PATH = ROOT / META_CATALOG.folder / "four_things.yaml"


@pytest.fixture
def catalog(library: Library) -> MetaCatalogDocument:
    return library.read(PATH, MetaCatalogDocument).document


def test_shipped_meta_catalog_has_no_diagnostics(library: Library) -> None:
    assert not check_document(PATH, Session(library))


def test_programs_and_stage_have_their_recorded_digests(
    catalog: MetaCatalogDocument, library: Library
) -> None:
    assert catalog.provenance is not None
    for identity in catalog.provenance.programs.values():
        file = library.locate(ProgramDocument, identity.name)
        assert program_digest(file, library).sha256 == identity.sha256
    known = catalog.provenance.stage
    stage = library.read(library.locate(StageDocument, known.name), StageDocument).document
    assert digest(stage) == known.sha256


def test_command_in_the_provenance_repeats_the_exploration(catalog: MetaCatalogDocument) -> None:
    assert catalog.provenance is not None and catalog.steps is not None
    words = shlex.split(catalog.provenance.command)
    options = dict(itertools.pairwise(words))
    assert (words[:3], options["--out"]) == (["cb", "explore", "stand"], PATH.name)
    assert int(options["--actions"]) == catalog.provenance.actions == len(catalog.steps.action)
    given = dict(each.split("=") for flag, each in itertools.pairwise(words) if flag == "--thing")
    assert given == {name: thing.feature for name, thing in catalog.things.items()}


def test_object_wider_than_the_hand_is_never_brought(catalog: MetaCatalogDocument) -> None:
    brought = {pair.upper for pair in catalog.pairs.values() if pair.rewarded}
    assert brought == set(catalog.things) - {"blue_box"}
    # No object stays on a ball.
    assert {pair.lower for pair in catalog.pairs.values() if pair.rewarded} == {
        "blue_box",
        "purple_box",
    }
    assert all(each.tried >= 3 for each in catalog.pairs.values())


def test_planned_stack_of_three_is_that_of_the_source(catalog: MetaCatalogDocument) -> None:
    plan = plan_stack(support_graph(catalog, ["football", "blue_box", "purple_box"]), 3)
    assert plan.order == ("blue_box", "purple_box", "football")
    assert 0.5 < plan.probability < 1


def test_standing_pair_has_a_model_with_all_its_successes(catalog: MetaCatalogDocument) -> None:
    for name, model in pair_models(catalog).items():
        assert model.successes == catalog.pairs[name].rewarded
        assert (model.rewarded.weight > 0) == (model.successes > 0)

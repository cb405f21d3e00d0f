"""Actions of explorations, read from texts and from catalogs."""

from __future__ import annotations

from cbdsl.api.requests.explored_actions import recorded_actions
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT


def test_recorded_actions_with_found_marks_search_for_other_hues_again() -> None:
    library = Library(ROOT)
    file = library.locate(CatalogDocument, "red_ball")
    catalog = library.read(file, CatalogDocument).document
    _, actions = recorded_actions(catalog, "exploring_red_ball")
    assert [action.name for action in actions] == list(catalog.affordances)
    (inspection,) = [action for action in actions if action.marks]
    assert inspection.name == "visualinspect"
    marks = {mark.name for mark in inspection.marks.values()}
    assert {"visualinspect_blue", "visualinspect_yellow"} < marks

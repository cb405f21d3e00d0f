"""Page of a meta-catalog in a real browser: it plans stacks of the available objects.

Needs Chromium, which is no dependency: without it these tests are skipped.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.yaml_text.library import Library
from cbdsl_report.meta_catalog_page import meta_catalog_page
from tests.conftest import ROOT
from tests.reporting.browser import CHROMIUM, Page, browser

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]

READY = "document.getElementById('ready')?.dataset.done"
LISTED = "[...document.querySelectorAll('#plans button')].map((each) => each.textContent)"
CHOSEN = "[...document.querySelectorAll('svg .chosen')].map((each) => each.dataset.key).sort()"


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    library = Library(ROOT)
    document = library.locate(MetaCatalogDocument, "four_things")
    file = tmp_path_factory.mktemp("page") / "things.html"
    text = meta_catalog_page(library.read(document, MetaCatalogDocument).document)
    Path(file).write_text(text, encoding="utf-8")
    with browser() as opened:
        opened.open(file, ready=READY)
        yield opened


def top_of(text: str) -> str:
    """Return the third object of a listed stack."""
    listed = re.match(r"blue_box < purple_box < (\w+)", text)
    assert listed is not None
    return listed[1]


def test_deselected_object_is_in_no_stack(shown: Page) -> None:
    first, second = shown.value(LISTED)
    top = top_of(first)
    shown.value(f"document.querySelector('[value={top}]').click()")
    assert shown.value(LISTED) == [second]
    shown.value("document.querySelector('[value=purple_box]').click()")
    assert shown.value(LISTED) == []
    assert "No such stack" in shown.text("told")
    for thing in (top, "purple_box"):
        shown.value(f"document.querySelector('[value={thing}]').click()")
    assert shown.value(LISTED) == [first, second]


def test_chosen_stack_is_marked_until_the_next_click(shown: Page) -> None:
    top = top_of(shown.value(LISTED)[0])
    shown.value("document.querySelector('#plans button').click()")
    parts = [top, "blue_box", "purple_box", "pair purple_box_on_blue_box"]
    stacks = [f"pair {top}_on_purple_box", f"stack blue_box purple_box {top}"]
    assert sorted(shown.value(CHOSEN)) == sorted([*parts, *stacks])
    shown.value("document.querySelector('#plans button').click()")
    assert shown.value(CHOSEN) == []


def test_page_has_no_errors_and_no_requests(shown: Page) -> None:
    assert shown.errors == [] and shown.text("problem") == ""
    assert [url for url in shown.requests if not url.startswith(("file:", "data:"))] == []

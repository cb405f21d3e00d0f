"""The documentation as a site: it is read, and searched, from files and without a network."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cbdsl.documents.kinds import entries
from tests.conftest import ROOT
from tests.reporting.browser import CHROMIUM, browser

PATIENCE = 30.0


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = (sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", folder)
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    subprocess.run(command, cwd=ROOT, env=quiet, check=True)
    return folder


@pytest.mark.slow
def test_no_page_loads_scripts_from_elsewhere(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert len(pages) > 30
    for page in pages:
        assert '<script src="http' not in page.read_text("utf-8"), page


@pytest.mark.slow
def test_site_holds_the_generated_parts_of_pages(site: Path) -> None:
    diagnostics = (site / "diagnostics.html").read_text("utf-8")
    assert diagnostics.count("<h2") == len(entries())
    assert 'id="resources-of-dexter"' in (site / "reference.html").read_text("utf-8")


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
@pytest.mark.parametrize("page", ["index.html", "how_to/new_robot.html"])
def test_search_finds_words_in_pages_that_are_read_from_files(site: Path, page: str) -> None:
    with browser() as shown:
        shown.visit((site / page).as_uri(), 1400, 1000, "document.readyState == 'complete'")
        shown.click(".md-search__input")
        for letter in "standoff":
            shown.press(letter)
        end = time.monotonic() + PATIENCE
        found = "document.querySelectorAll('.md-search-result__item').length"
        while not shown.value(found) and time.monotonic() < end:
            time.sleep(0.1)
        assert shown.value(found) > 2
        assert not [each for each in shown.requests if each.startswith("http")]
        assert shown.errors == []

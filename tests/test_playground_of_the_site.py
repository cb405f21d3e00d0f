"""Playground of the documentation: the checker in Python that a browser runs, without a server."""

from __future__ import annotations

import runpy
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import quote, urlsplit
from zipfile import ZipFile

import pytest

from tests.conftest import ROOT
from tests.reporting.browser import CHROMIUM, browser

MAKE = ROOT / "docs" / "make_playground.py"
PATIENCE = 60.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made: Path = tmp_path_factory.mktemp("playground")
    try:
        runpy.run_path(str(MAKE))["main"](made)
    except SystemExit as error:
        pytest.skip(str(error))
    return made


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    handler = partial(SimpleHTTPRequestHandler, directory=str(folder))
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/index.html"
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.mark.slow
def test_folder_has_20_mb_and_a_licence_of_each_package(folder: Path) -> None:
    assert sum(file.stat().st_size for file in folder.iterdir()) == pytest.approx(20e6, rel=0.1)
    names = ZipFile(folder / "packages.zip").namelist()
    packages = {name.partition("/")[0] for name in names if ".dist-info/" in name}
    licences = [name for name in names if "LICENSE" in name]
    assert len(packages) > 10 and "__pycache__" not in " ".join(names)
    assert {name.partition("/")[0] for name in licences} >= packages


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_page_checks_and_draws_in_the_browser_alone(address: str) -> None:
    steps = "[...document.querySelectorAll('#automaton [data-node]')].map(e => e.dataset.node)"
    with browser() as page:
        page.visit(address, 1400, 1000, "!!document.getElementById('state')")
        page.wait("document.getElementById('state').textContent === 'no errors'", PATIENCE)
        assert page.value(steps) == ["open", "away", "back", "succeed"]
        page.value(
            "{const t = document.getElementById('text');"
            "t.value = t.value.replace('robot: dexter', 'robot: dextre');"
            "t.dispatchEvent(new Event('input'));}"
        )
        page.wait("document.querySelectorAll('#findings .error').length")
        assert not page.value("document.getElementById('run').checkVisibility()")
        hosts = {urlsplit(each).netloc for each in page.requests if each.startswith("http")}
        assert hosts == {urlsplit(address).netloc} and page.errors == []


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_page_opens_the_example_of_its_address(address: str) -> None:
    text = (ROOT / "programs" / "take.yaml").read_text("utf-8").replace("dexter", "dextre")
    with browser() as page:
        page.visit(
            f"{address}#text={quote(text)}", 1400, 1000, "!!document.getElementById('state')"
        )
        page.wait("document.querySelectorAll('#findings .error').length", PATIENCE)
        assert page.value("document.getElementById('text').value") == text

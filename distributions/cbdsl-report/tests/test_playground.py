"""Playground: a page that checks, draws and runs programs, for this machine alone."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from cbdsl.reporting.live.feed import Feed
from cbdsl.reporting.live.page_server import LiveServer, RequestError
from cbdsl_report import playground
from cbdsl_report.playground import PlaygroundRequests, playground_page
from tests.conftest import ROOT
from tests.reporting.browser import CHROMIUM, browser

LET_GO = (ROOT / "programs" / "let_go.yaml").read_text("utf-8")
WRONG = LET_GO.replace("robot: dexter", "robot: dextre")


@pytest.fixture
def requests() -> Iterator[PlaygroundRequests]:
    made = PlaygroundRequests()
    yield made
    made.close()


@pytest.fixture
def server(requests: PlaygroundRequests) -> Iterator[LiveServer]:
    made = LiveServer(Feed(), lambda token: playground_page(LET_GO, token), requests)
    yield made
    made.close()


def test_check_returns_findings_and_a_picture_of_the_steps(requests: PlaygroundRequests) -> None:
    right = requests({"text": LET_GO})
    assert right["findings"] == [] and 'data-node="open"' in right["steps"]
    wrong = requests({"text": WRONG})
    assert wrong["steps"] == ""
    assert (
        "dexter" in wrong["findings"][0]["allowed"] or wrong["findings"][0]["nearest"] == "dexter"
    )


def test_check_ignores_warnings_of_its_commands(
    requests: PlaygroundRequests, monkeypatch: pytest.MonkeyPatch
) -> None:
    warns = "import sys; print('warning: a plug-in', file=sys.stderr); "
    python, option, command = playground._CB
    monkeypatch.setattr(playground, "_CB", (python, option, warns + command))
    assert 'data-node="open"' in requests({"text": LET_GO})["steps"]


@pytest.mark.parametrize("text", ["", "name: ../x", "\ud800", "a: [" * 2000, "name: let_go\n" * 3])
def test_check_of_any_text_returns_findings(text: str, requests: PlaygroundRequests) -> None:
    answer = requests({"text": text})
    assert answer["findings"] and answer["steps"] == ""


def test_run_returns_the_output_and_leaves_no_file(
    requests: PlaygroundRequests, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = requests({"text": LET_GO, "seed": 1})
    assert "Succeeded after" in answer["output"]
    assert not list(tmp_path.iterdir())


def test_second_request_is_refused_while_one_runs(requests: PlaygroundRequests) -> None:
    first = threading.Thread(target=requests, args=({"text": LET_GO},))
    first.start()
    until = time.monotonic() + 10.0
    while not requests._turn.locked() and time.monotonic() < until:
        time.sleep(0.001)
    with pytest.raises(RequestError, match="still"):
        requests({"text": LET_GO})
    first.join()


def test_request_without_the_token_is_refused(server: LiveServer) -> None:
    address = urlsplit(server.url)
    assert address.hostname == "127.0.0.1"
    connection = HTTPConnection(address.hostname, address.port or 0, timeout=10)
    connection.request("POST", f"{address.path}request", b'{"text": ""}')
    assert connection.getresponse().status == 403


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_page_checks_draws_and_runs_in_a_browser(server: LiveServer) -> None:
    checked = "document.getElementById('state').textContent.includes('errors')"
    with browser() as page:
        page.visit(server.url, 1400, 1000, checked)
        steps = "[...document.querySelectorAll('#automaton [data-node]')].map(e => e.dataset.node)"
        assert page.value(steps) == ["open", "away", "back", "succeed"]
        page.value(
            "{const t = document.getElementById('text');"
            "t.value = t.value.replace('robot: dexter', 'robot: dextre');"
            "t.dispatchEvent(new Event('input'));}"
        )
        page.wait("document.querySelectorAll('#findings .error').length")
        page.click("#findings .error")
        chosen = "{0}.value.slice({0}.selectionStart, {0}.selectionEnd)"
        assert page.value(chosen.format("document.getElementById('text')")) == "dextre"
        assert page.value("document.getElementById('run').disabled")
        page.value(
            "{const t = document.getElementById('text');"
            "t.value = t.value.replace('robot: dextre', 'robot: dexter');"
            "t.dispatchEvent(new Event('input'));}"
        )
        page.wait("!document.getElementById('run').disabled")
        page.click("#run")
        page.wait("document.getElementById('output').textContent.includes('Succeeded after')")
        assert {urlsplit(each).netloc for each in page.requests if each.startswith("http")} <= {
            urlsplit(server.url).netloc
        }
        assert page.errors == []

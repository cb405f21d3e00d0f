"""Live page of an exploration in a real browser: its catalog grows with each action.

Needs Chromium, which is no dependency: without it these tests are skipped.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.reporting.live.exploration_view import ExplorationView
from cbdsl.reporting.live.feed import Feed
from cbdsl.reporting.live.live_page import live_page
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.page_server import LiveServer
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.transport import Transport
from tests.reporting.browser import CHROMIUM, browser
from tests.reporting.conftest import Shown
from tests.reporting.live.conftest import Watched
from tests.reporting.live.explored import PLACE, exploration, missed, reached

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]

ROWS = "[...document.querySelectorAll('#affordances tbody tr')].map(r => r.innerText)"
NOW = "[...document.querySelectorAll('#affordances .now')].map(r => r.dataset.name).join()"
ICON = "document.getElementById('icon')"
CHARTS = "document.querySelectorAll('#course canvas').length"


@pytest.fixture
def view(dexter: RobotDocument, urdf: Path) -> Iterator[tuple[ExplorationView, str]]:
    feed, transport = Feed(), Transport(math.inf)
    server = LiveServer(
        feed, lambda token: live_page("reach", dexter, urdf, token), Requests(transport)
    )
    yield ExplorationView(LiveView(feed, transport, Shown), "ball", "yellow", 3), server.url
    server.close()


def test_catalog_grows_on_the_page(view: tuple[ExplorationView, str], watched: Watched) -> None:
    shown, url = view
    explored = exploration()
    shown.note_choice("reach")
    watched(shown)
    with browser() as page:
        page.visit(url, 1400, 1000, "document.body.dataset.time")
        page.wait("!document.getElementById('catalog').hidden")
        assert "0 of 3 actions are over: reach" in page.text("catalog-heading")
        explored.note(reached(0.5))
        shown.note_step(explored)
        page.wait(f"{ROWS}.length === 3")
        reach, lift, noop = page.value(ROWS)
        assert "1 of 1" in reach and "0 of 0" in lift and "taken 0" in noop
        page.wait(f"{ICON}.complete && {ICON}.naturalWidth > 0 && !{ICON}.hidden")
        page.wait(f"{CHARTS} === 4")
        shown.note_choice("lift")
        page.wait(f"{NOW} === 'lift'")
        watched(shown)
        explored.add({"inspect": PLACE})
        explored.note(missed(0.9))
        shown.note_step(explored)
        page.wait(f"{ROWS}.length === 4")
        assert "1 of 2" in page.value(ROWS)[0] and page.value(NOW) == ""
        page.wait(f"{CHARTS} === 4")
        assert "reachtouch, seed" in page.text("episodes")
        assert page.errors == [] and page.text("problem") == ""
        assert {each.split("/")[2] for each in page.requests if each.startswith("http")} == {
            url.split("/")[2]
        }

"""The live page in a real browser: it follows a run, pauses it, and asks nobody else.

Needs Chromium, which is no dependency: without it these tests are skipped.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.reporting.live.feed import Feed
from cbdsl.reporting.live.live_page import live_page
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.server import LiveServer
from cbdsl.reporting.live.transport import Transport
from cbdsl.runtime.episode import EpisodeResult
from cbdsl.sensing.kinematics import Kinematics
from tests.reporting.browser import CHROMIUM, Page, browser
from tests.reporting.conftest import Shown
from tests.reporting.live.conftest import Watched

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]

NOW = "Number(document.body.dataset.time)"
LEVELS = "[...document.querySelectorAll('#levels tbody tr')].map(r => r.dataset.name)"
READY = "document.body.dataset.time"


class Run:
    """A run in a thread of its own, which begins in a pause, and its server."""

    def __init__(self, watched: Watched, robot: RobotDocument, urdf: Path) -> None:
        self.feed, self.transport = Feed(), Transport(math.inf)
        self.view = LiveView(self.feed, self.transport, Shown)
        self.server = LiveServer(
            self.feed,
            lambda token: live_page("reachtouch", robot, urdf, token),
            Requests(self.transport),
        )
        self.results: list[EpisodeResult] = []
        self.transport.pause()
        self._thread = Thread(target=lambda: self.results.append(watched(self.view)))
        self._thread.start()

    def close(self) -> None:
        self.transport.hasten(math.inf)
        self.transport.release()
        self._thread.join()
        self.server.close()


@pytest.fixture
def run(watched: Watched, dexter: RobotDocument, urdf: Path) -> Iterator[Run]:
    made = Run(watched, dexter, urdf)
    yield made
    made.close()


@pytest.fixture
def shown(run: Run) -> Iterator[Page]:
    with browser() as opened:
        opened.visit(run.server.url, 1400, 1300, READY)
        yield opened
        opened.wait("true")
        assert opened.errors == []
        assert {url.split("/")[2] for url in opened.requests if url.startswith("http")} == {
            run.server.url.split("/")[2]
        }


def test_it_follows_a_run_from_its_pause_to_its_end(
    run: Run, shown: Page, kinematics: Kinematics
) -> None:
    shown.wait("document.getElementById('pause').textContent.includes('Go on')")
    began = shown.value(NOW)
    shown.press("s")
    shown.wait(f"{NOW} > {began}")
    assert shown.value(NOW) == pytest.approx(began + 0.02, abs=0.02)
    first = shown.value("linkAt('right_palm')")
    assert "running" in shown.text("verdict")
    shown.click("#pause")
    shown.wait("document.getElementById('ending').textContent")
    result = run.results[0]
    assert shown.text("ending") == result.ending
    shown.wait(f"{NOW} >= {result.sim_seconds - 0.001}")
    assert shown.value("document.querySelectorAll('#transitions li').length") >= len(result.actions)
    assert "touch 1" in shown.text("state")
    last = shown.value("linkAt('right_palm')")
    assert np.linalg.norm(np.subtract(last, first)) > 0.1, "the robot moves on the page, too"
    assert shown.text("problem") == ""


def test_the_stack_is_in_the_order_of_priority(run: Run, shown: Page) -> None:
    run.transport.step(60)
    shown.wait(f"{LEVELS}.includes('approach')")
    names = shown.value(LEVELS)
    assert names.index("approach") < names.index("orient") < names.index("posture")


def test_when_the_server_ends_the_page_says_so(run: Run, shown: Page) -> None:
    run.close()
    shown.wait("document.getElementById('link').textContent.includes('over')")
